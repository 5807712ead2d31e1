"""The table of the next piece: against hand-worked numbers, SciPy's Gaussian, and a simulated axis."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from leadscrew.tangent.piece_learning import next_offsets, next_offsets_along, next_offsets_textbook
from leadscrew.util.errors import DataError, ValueRefused

RNG = np.random.default_rng(3)
N = 120


def row():
    return RNG.normal(size=N)


def test_hand_worked_piece():
    """Offset 1 sent, deviation 0.45 two samples later: -0.45 / 0.9 too much; with gain 0.5 half of the way from 2."""
    u, d = np.full(6, 2.0), np.full(6, 1.0)
    e = np.array([9.0, 9.0, 0.45, 0.45, 0.45, 0.45])
    assert np.allclose(next_offsets(u, d, e, gain=0.5, lead=2, width=0.0), 0.5 * 2.0 + 0.5 * (1.0 - 0.5))


def test_hand_worked_textbook():
    u, e = np.array([1.0, 1.0, 1.0, 1.0]), np.array([9.0, 0.5, 0.25, 0.0])
    assert np.allclose(next_offsets_textbook(u, e, gain=0.8, lead=1, width=0.0), [0.6, 0.8, 1.0, 1.0])


def test_without_feedback_both_forms_agree():
    """Where only the table was sent, the command form with L is the textbook form with L / g."""
    u, e = row(), row()
    ours = next_offsets(u, u, e, gain=0.72, lead=0, width=1.5, plant_gain=0.9)
    assert np.allclose(ours, next_offsets_textbook(u, e, gain=0.8, lead=0, width=1.5), atol=1e-12)


@pytest.mark.parametrize("closed", [True, False])
def test_the_gaussian_is_scipys(closed):
    """Closed: SciPy's with wrapped ends. Open: zeros outside, divided by what the same does to ones."""
    u, width = row(), 2.5
    ours = next_offsets(u, u, np.zeros(N), gain=0.0, width=width, closed=closed)
    if closed:
        theirs = gaussian_filter1d(u, width, mode="wrap", truncate=4.0)
    else:
        outside = {"mode": "constant", "truncate": 4.0}
        theirs = gaussian_filter1d(u, width, **outside) / gaussian_filter1d(np.ones(N), width, **outside)
    assert np.allclose(ours, theirs, atol=1e-12)


def test_an_open_path_keeps_a_constant_to_its_ends():
    flat = np.full(N, 3.0)
    assert np.allclose(next_offsets(flat, flat, np.zeros(N), width=5.0), flat, atol=1e-12)


def test_behind_the_end_the_last_known_target_stays():
    e = np.zeros(N)
    e[-1] = 0.9
    found = next_offsets(np.zeros(N), np.zeros(N), e, gain=1.0, lead=6, width=0.0)
    assert np.allclose(found[-7:], -1.0) and not found[:-7].any()


def test_on_a_closed_path_the_start_shows_the_end():
    e = np.zeros(N)
    e[2] = 0.9
    found = next_offsets(np.zeros(N), np.zeros(N), e, gain=1.0, lead=6, width=0.0, closed=True)
    assert np.flatnonzero(found).tolist() == [N - 4]


@pytest.mark.parametrize("kp", [0.0, 0.4])
def test_deviation_shrinks_by_a_fifth_a_piece_whatever_the_feedback(kp):
    """e(k + 3) = 0.9 d(k) + c(k + 3), and d may hold feedback: what the table lacks is 0.2 of the piece before."""
    c = np.convolve(RNG.normal(size=N + 40), np.ones(40) / 40.0, "valid")[:N]
    u, needed = np.zeros(N), -c / 0.9
    lacking = []
    for _ in range(4):
        e, d = np.zeros(N), np.zeros(N)
        for k in range(N):
            e[k] = c[k] + (0.9 * d[k - 3] if k >= 3 else 0.0)
            d[k] = u[k] - kp * e[k]
        u = next_offsets(u, d, e, gain=0.8, lead=3, width=0.0)
        lacking.append(np.abs(u[: N - 3] - needed[3:]).max())
    assert np.allclose(np.array(lacking[1:]) / lacking[:-1], 0.2, atol=1e-6)


def test_pieces_side_by_side_are_the_single_ones():
    u, d, e = (RNG.normal(size=(2, 3, N)) for _ in range(3))
    together = next_offsets(u, d, e)
    assert np.array_equal(together[1, 2], next_offsets(u[1, 2], d[1, 2], e[1, 2]))


def smooth(s):
    return 2.0 * np.sin(s / 7.0), 1.5 * np.cos(s / 9.0), 0.5 * np.sin(s / 5.0 + 1.0)


def test_arc_length_form_is_the_sampled_one_on_even_places():
    s = 0.5 * np.arange(N)
    u, d, e = smooth(s)
    along = next_offsets_along(s, u, d, s, e, lead_mm=1.0, width_mm=0.75)
    assert np.abs(along - next_offsets(u, d, e, lead=2, width=1.5))[5:-10].max() < 0.01


def test_arc_length_form_does_not_see_how_the_piece_was_sampled():
    even = np.linspace(0.0, 60.0, 2000)
    uneven = np.sort(np.r_[0.0, 60.0, RNG.uniform(0.0, 60.0, 900)])
    scan = np.linspace(0.0, 60.0, 777)
    u, d, _ = smooth(even)
    fine = next_offsets_along(even, u, d, scan, smooth(scan)[2])
    u, d, _ = smooth(uneven)
    other = next_offsets_along(uneven, u, d, scan, smooth(scan)[2])
    assert np.abs(np.interp(uneven, even, fine) - other).max() < 0.01


def test_arc_length_form_closes_the_path():
    """A deviation just behind the start is made up for just before the end."""
    s = np.arange(0.0, 100.0, 0.5)
    e = np.where(np.abs(s - 1.0) < 0.3, 0.9, 0.0)
    found = next_offsets_along(s, 0.0 * s, 0.0 * s, s, e, gain=1.0, lead_mm=3.0, width_mm=0.0, length_mm=100.0)
    assert np.flatnonzero(found).tolist() == [196]  # 98 mm = 1 - 3 + 100
    open_end = next_offsets_along(s, 0.0 * s, 0.0 * s, s, e, gain=1.0, lead_mm=3.0, width_mm=0.0)
    assert not open_end.any()


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"gain": 2.5}, "gain = 2.5"),
        ({"lead": -1}, "lead = -1"),
        ({"lead": 1.5}, "lead = 1.5"),
        ({"lead": N}, f"lead = {N}"),
        ({"width": -1.0}, "width = -1.0"),
        ({"plant_gain": 0.0}, "plant_gain = 0.0"),
    ],
)
def test_settings_out_of_range_are_refused(changes, said):
    with pytest.raises(ValueRefused, match=said):
        next_offsets(np.zeros(N), np.zeros(N), np.zeros(N), **changes)


def test_rows_that_do_not_fit_are_refused():
    with pytest.raises(DataError, match="e of shape"):
        next_offsets(np.zeros(N), np.zeros(N), np.zeros(N - 1))
    with pytest.raises(DataError, match="diverged"):
        next_offsets(np.zeros(N), np.zeros(N), np.full(N, np.nan))
    with pytest.raises(DataError, match="ascending"):
        next_offsets_along([0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [0.0, 1.0], [0.0, 0.0])
    with pytest.raises(ValueRefused, match="length_mm"):
        next_offsets_along([0.0, 5.0], [0.0, 0.0], [0.0, 0.0], [0.0, 5.0], [0.0, 0.0], length_mm=4.0)
