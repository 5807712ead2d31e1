"""The scope takes what a person would pick from the whole record by eye."""

import itertools
import resource

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from leadscrew.operate.scope import RING_BYTES, Scope, Trigger, noise
from leadscrew.util.errors import NameUnknown, ValueRefused

PERIOD = 1e-3


def record(signal):
    """Rows with their period's number in a column of its own."""
    return np.column_stack([np.arange(len(signal)) * PERIOD, np.arange(float(len(signal))), signal])


def scope(seconds=2.0):
    return Scope(["time", "number", "x"], {"time": "s", "x": "mm"}, PERIOD, seconds)


def fed(into, rows, cuts=(), first=0):
    """Feeds rows in chunks; the captures that came."""
    found = []
    for start, end in zip([0, *cuts], [*cuts, len(rows)], strict=True):
        into.feed(first + start, rows[start:end])
        if (capture := into.taken()) is not None:
            found.append(capture)
    return found


def crossings(x, level, slope):
    """Rows in which the level is reached, one by one."""
    pairs = enumerate(itertools.pairwise(x), start=1)
    up = {"rising": [1], "falling": [-1], "either": [1, -1]}[slope]
    return [k for k, (a, b) in pairs if any(s * a < s * level <= s * b for s in up)]


@pytest.mark.parametrize("slope", ["rising", "falling", "either"])
def test_a_single_capture_has_the_first_crossing_at_its_trigger_row(slope):
    x = np.cos(2 * np.pi * 3.0 * np.arange(2000) * PERIOD)
    taker = scope()
    taker.arm(Trigger("x", 0.3, slope, "single", pre=0.25, length_s=0.05))
    (capture,) = fed(taker, record(x))
    assert capture.rows[capture.trigger_row, 1] == crossings(x, 0.3, slope)[0]
    assert len(capture.rows) == 50 and capture.trigger_row == round(0.25 * 49)
    assert capture.first_period == capture.rows[0, 1] and np.all(np.diff(capture.rows[:, 1]) == 1.0)
    assert capture.signal("x")[capture.trigger_row] == x[int(capture.rows[capture.trigger_row, 1])]
    assert capture.time()[capture.trigger_row] == 0.0 and capture.units["x"] == "mm"
    assert taker.state()["phase"] == "done" and taker.taken() is None


def test_a_value_equal_to_the_level_has_reached_it():
    taker = scope()
    taker.arm(Trigger("x", 1.0, pre=0.0, length_s=0.002))
    (capture,) = fed(taker, record(np.array([0.0, 0.5, 1.0, 1.5])))
    assert capture.rows[0, 1] == 2.0


def test_a_signal_above_the_level_from_the_start_fires_only_after_it_was_below():
    taker = scope()
    taker.arm(Trigger("x", 0.5, pre=0.0, length_s=0.002))
    (capture,) = fed(taker, record(np.array([1.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0])))
    assert capture.rows[0, 1] == 5.0


CUTS = st.lists(st.integers(1, 1199), max_size=12, unique=True).map(sorted)


@settings(max_examples=60, deadline=None)
@given(
    cuts=CUTS,
    seed=st.integers(0, 1000),
    slope=st.sampled_from(["rising", "falling", "either"]),
    mode=st.sampled_from(["single", "normal", "auto"]),
    pre=st.floats(0.0, 1.0),
    rows=st.integers(2, 300),
    armed=st.integers(0, 600),
    gap=st.booleans(),
)
def test_any_chunking_of_the_feed_gives_the_same_captures(cuts, seed, slope, mode, pre, rows, armed, gap):
    rng = np.random.default_rng(seed)
    x = np.cumsum(rng.normal(size=1200)) * 0.2 + 2.0 * np.sin(np.arange(1200) / 40)
    x[rng.integers(0, 1200, 5)] = np.nan
    whole = record(x)

    def taken(cuts):
        taker = scope(0.3)
        cuts = sorted({*cuts, armed, 700} - {0})
        for start, end in zip([0, *cuts], [*cuts, 1200], strict=True):
            if start == armed:
                taker.arm(Trigger("x", 0.5, slope, mode, pre, rows * PERIOD))
            # The gap: from row 700 on, the periods are 5000 later.
            taker.feed(start + 5000 * (gap and start >= 700), whole[start:end])
        capture, state = taker.taken(), taker.state()
        return capture, state

    (one, state), (other, state_too) = taken(cuts), taken(())
    assert state == state_too
    assert (one is None) == (other is None)
    if one is not None and other is not None:
        assert np.array_equal(one.rows, other.rows, equal_nan=True)
        assert (one.first_period, one.trigger_row) == (other.first_period, other.trigger_row)
        assert np.all(np.diff(one.rows[:, 1]) == 1.0)
        crossed = not (one.rows[0, 1] < 700 <= one.rows[-1, 1])
        assert crossed or not gap


def test_noise_around_the_level_fires_once_in_normal_and_again_only_after_a_real_move():
    rng = np.random.default_rng(3)
    move = np.concatenate(
        [np.linspace(-1, 0, 2000), np.zeros(20_000), np.linspace(0, -1, 2000), np.linspace(-1, 1, 2000)]
    )
    x = move + rng.normal(0.0, 0.02, len(move))
    assert len(crossings(x, 0.0, "rising")) > 1000
    taker = scope()
    taker.arm(Trigger("x", 0.0, mode="normal", length_s=0.05))
    found = fed(taker, record(x), range(20, len(x), 20))
    places = [int(c.rows[c.trigger_row, 1]) for c in found]
    assert len(places) == 2
    assert abs(places[0] - 2000) < 250 and abs(places[1] - 25_000) < 250


def test_a_smooth_sine_fires_in_every_period_although_noise_has_its_hysteresis():
    x = np.sin(2 * np.pi * 20.0 * np.arange(4000) * PERIOD)
    taker = scope()
    taker.arm(Trigger("x", 0.5, mode="normal", length_s=0.02))
    assert len(fed(taker, record(x), range(10, 4000, 10))) == pytest.approx(80, abs=1)


def test_a_given_hysteresis_is_kept():
    x = np.array([-1.0, 0.1, -0.3, 0.1, -0.3, 0.1, -1.0, 0.1, 0.1, 0.1])
    taker = scope()
    taker.arm(Trigger("x", 0.0, mode="normal", pre=0.0, length_s=0.002, hysteresis=0.5))
    found = fed(taker, record(x), range(1, 10))
    assert [c.rows[0, 1] for c in found] == [1.0, 7.0]


@pytest.mark.parametrize("slope", ["rising", "falling", "either"])
def test_a_signal_that_rests_at_the_level_never_fires(slope):
    taker = scope()
    taker.arm(Trigger("x", 0.25, slope, pre=0.0, length_s=0.002, hysteresis=0.0))
    assert fed(taker, record(np.full(20, 0.25)), [5]) == []


def test_the_hysteresis_is_by_the_standard_deviation_of_the_noise():
    # 2000 rows: the median of their third differences is within 5 % (three deviations) in all of these seeds.
    for seed in range(3):
        white = np.random.default_rng(seed).normal(0.0, 0.02, 2000)
        assert noise(white) == pytest.approx(0.02, rel=0.08)
        assert noise(white + 5.0 * np.linspace(-1.0, 1.0, 2000) ** 2) == pytest.approx(noise(white), rel=0.01)


def test_auto_fires_after_a_while_without_a_trigger_and_at_the_level_where_there_is_one():
    x = np.zeros(1500)
    x[900:] = 1.0
    taker = scope()
    taker.arm(Trigger("x", 0.5, mode="auto", pre=0.5, length_s=0.1))
    found = fed(taker, record(x), range(50, 1500, 50))
    assert [c.about["trigger"]["fired"] for c in found[:2]] == ["auto", "level"]
    assert found[0].rows[found[0].trigger_row, 1] == 499.0 and found[1].rows[found[1].trigger_row, 1] == 900.0


def test_nothing_that_is_not_a_number_fires():
    x = np.array([0.0, np.nan, 1.0, 1.0, 0.0, np.inf, 1.0, -np.inf, 1.0, np.nan, np.nan])
    taker = scope()
    taker.arm(Trigger("x", 0.5, "either", pre=0.0, length_s=0.002))
    (capture,) = fed(taker, record(x))
    assert capture.rows[0, 1] == 4.0, "the step down from 1 to 0 is the first between two numbers"


def test_a_jump_of_the_periods_is_in_no_capture():
    x = np.zeros(300)
    x[90:] = 1.0
    x[150:200] = 0.0
    rows = record(x)
    taker = scope()
    taker.arm(Trigger("x", 0.5, pre=0.5, length_s=0.06))
    assert not fed(taker, rows[:100])
    assert taker.state()["phase"] == "taking"
    (capture,) = fed(taker, rows[120:], first=120)
    assert capture.rows[capture.trigger_row, 1] == 200.0 and np.all(np.diff(capture.rows[:, 1]) == 1.0)
    assert "jumped" in taker.state()["message"]


def test_a_reset_to_period_zero_is_a_jump_too():
    taker = scope()
    fed(taker, record(np.zeros(100)))
    taker.arm(Trigger("x", 0.5, pre=0.9, length_s=0.05))
    (capture,) = fed(taker, record(np.r_[np.zeros(5), np.ones(50)]))
    assert capture.first_period == 0 and capture.trigger_row == 5


def test_history_before_the_arming_comes_before_the_trigger():
    taker = scope()
    x = np.r_[np.zeros(500), np.ones(500)]
    fed(taker, record(x)[:500])
    taker.arm(Trigger("x", 0.5, pre=1.0, length_s=0.4))
    taker.feed(500, record(x)[500:501])
    capture = taker.taken()
    assert capture.first_period == 101 and capture.trigger_row == 399 == len(capture.rows) - 1


def test_force_takes_what_is_there_at_once_and_armed_again_where_it_was():
    taker = scope()
    taker.force()
    (capture,) = fed(taker, record(np.zeros(1500)))
    assert capture.about["trigger"]["fired"] == "forced" and capture.first_period == 0 and capture.trigger_row == 0
    taker.arm(Trigger("x", 9.0, mode="normal", pre=0.5, length_s=0.1))
    taker.force()
    taker.feed(1500, record(np.zeros(200))[:, :])
    assert taker.taken().trigger_row == 50 and taker.state()["phase"] == "armed"
    taker.disarm()
    taker.force()
    taker.feed(1700, record(np.zeros(200)))
    assert taker.taken() is not None and taker.state()["phase"] == "done"


def test_a_disarmed_scope_drops_what_it_was_taking():
    taker = scope()
    taker.arm(Trigger("x", 0.5, length_s=1.0))
    fed(taker, record(np.r_[0.0, 1.0]))
    taker.disarm()
    assert not fed(taker, record(np.zeros(3000)), first=2)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"signal": "y"}, "did you mean|known"),
        ({"signal": "numbr"}, "number"),
        ({"level": float("nan")}, "NaN"),
        ({"level": float("inf")}, "finite"),
        ({"level": "1"}, "expected a number"),
        ({"level": True}, "expected a number"),
        ({"slope": "up"}, "rising, falling, either"),
        ({"mode": "once"}, "single, normal, auto"),
        ({"pre": 1.01}, r"\[0, 1\]"),
        ({"pre": -0.01}, r"\[0, 1\]"),
        ({"length_s": 2.1}, r"\[0.002, 2\] s"),
        ({"length_s": 1e300}, r"\[0.002, 2\] s"),
        ({"length_s": float("inf")}, r"\[0.002, 2\] s"),
        ({"length_s": 0.0}, r"\[0.002, 2\] s"),
        ({"hysteresis": -1.0}, r"\[0, inf\)"),
    ],
)
def test_a_trigger_that_cannot_be_is_refused_in_a_sentence_and_the_armed_one_stays(change, says):
    taker = scope()
    taker.arm(Trigger("x", 0.5, length_s=0.1))
    before = taker.state()
    with pytest.raises((ValueRefused, NameUnknown), match=says) as refused:
        taker.arm(Trigger(**{"signal": "x", "level": 0.0, "length_s": 0.5, **change}))
    assert "\n" not in str(refused.value)
    assert taker.state() == before


def test_rows_of_another_shape_are_refused():
    with pytest.raises(ValueRefused, match=r"expected \(n, 3\)"):
        scope().feed(0, np.zeros((4, 2)))


def test_memory_is_bounded_and_does_not_grow_while_it_runs():
    wide = Scope([f"s{k}" for k in range(200)], {}, 1e-4, seconds=1e4)
    assert wide.capacity * 200 * 8 <= RING_BYTES
    wide.arm(Trigger("s0", 1.0, mode="normal", length_s=0.01))
    rows = np.zeros((1000, 200))
    wide.feed(0, rows)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for k in range(1, 60):
        wide.feed(1000 * k, rows)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 2000, "kB"


def test_what_it_is_about_is_added_to_the_capture_and_its_state_is_json():
    import json

    taker = scope()
    taker.arm(Trigger("x", 0.5, length_s=0.01))
    taker.feed(0, record(np.r_[np.zeros(20), np.ones(20)]))
    json.dumps(taker.state(), allow_nan=False)
    capture = taker.taken({"study": "npid_xytable"})
    assert (
        capture.about["study"] == "npid_xytable" and capture.about["trigger"]["signal"] == "x" and capture.about["when"]
    )
