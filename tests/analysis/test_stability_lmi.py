"""Certificates by matrix inequalities: hand-worked limits, exactness, rounding, refusals, and what they promise."""

import dataclasses
import math
from fractions import Fraction

import numpy as np
import pytest

from leadscrew.analysis.stability.criteria import ask
from leadscrew.analysis.stability.exact import positive_definite, proved, rational
from leadscrew.analysis.stability.linear import LinearLoop
from leadscrew.analysis.stability.lmi import (
    ROUNDING,
    driven,
    inequality,
    jury_lee_inequality,
    largest_proved,
    popov_inequality,
    prove,
    tsypkin_inequality,
    zames_falb_inequality,
)
from leadscrew.analysis.stability.loop import continuous_loop
from leadscrew.analysis.stability.lure import lure
from leadscrew.controllers._npid import npid
from leadscrew.controllers._npid_slope import npid_slope
from leadscrew.studies.npid_xytable.reference_loops import reference_loops
from leadscrew.util.errors import ValueRefused


def first_order(pole=0.5):
    return LinearLoop(np.array([[pole]]), np.ones((1, 1)), np.ones((1, 1)), np.zeros((1, 1)), 1.0, name="first order")


@pytest.fixture(scope="module")
def star():
    return reference_loops()["L_star"]


def test_definiteness_is_decided_where_floating_point_cannot():
    hair = Fraction(1, 2**200)
    just = np.array([[Fraction(1), Fraction(1)], [Fraction(1), 1 + hair]], dtype=object)
    not_quite = np.array([[Fraction(1), Fraction(1)], [Fraction(1), 1 - hair]], dtype=object)
    assert positive_definite(just) and not positive_definite(not_quite)
    hilbert = np.array([[Fraction(1, i + j + 1) for j in range(12)] for i in range(12)], dtype=object)
    assert positive_definite(hilbert)
    smallest = hilbert - np.diag([Fraction(1, 10**15)] * 12)  # its smallest eigenvalue is 2.6e-17
    assert not positive_definite(smallest)


def test_a_multiplier_that_looks_back_asks_the_function_for_more_than_the_energy_it_takes():
    """By hand: 2 |q| k times the integral of w, at most k e^2 / 2, so the floor is |q| k^2 e^2."""
    k1, k2, q = 0.25, 1.25, -0.5
    for lmi in (
        tsypkin_inequality(first_order(), k1, k2, q, 4.0), jury_lee_inequality(first_order(), k1, k2, q, 4.0)
    ):  # fmt: skip
        # states: the loop's own, the last e, the last v
        assert lmi.order == 3 and lmi.floor.astype(float).tolist() == [[0.0, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0] * 3]
    second = LinearLoop(
        np.array([[-1.0, 0.0], [1.0, -2.0]]), np.array([[1.0], [0.0]]), np.array([[3.0, 2.0]]), np.zeros((1, 1)), None
    )
    floor = popov_inequality(second, 0.0, 2.0, -0.25).floor.astype(float)  # e = -(3 x1 + 2 x2)
    assert floor.tolist() == [[9.0, 6.0], [6.0, 4.0]]
    assert tsypkin_inequality(first_order(), k1, k2, 0.5, 4.0).floor is None
    assert popov_inequality(second, 0.0, 2.0, 0.25).floor is None


def test_a_proof_needs_a_function_above_its_floor():
    """x+ = x / 2 with V = 1.5 x^2: it falls, and is more than a floor of 1.49 x^2 but not more than one of 1.5 x^2."""
    lmi = inequality(first_order(), 0.0, 0.5)
    p = np.array([[1.5]])
    for floor, proof in ((None, True), (1.49, True), (1.5, False), (1.51, False)):
        level = None if floor is None else rational(np.array([[floor]]))
        assert (proved(dataclasses.replace(lmi, floor=level), p) is not None) is proof, floor


def test_a_double_is_taken_as_the_fraction_that_it_is():
    assert rational(np.array([0.1]))[0] == Fraction(3602879701896397, 2**55)


def test_the_sampled_limit_of_a_first_order_loop_is_the_one_worked_by_hand():
    # G = 1/(z - 1/2): the smallest real part is -2/3, at z = -1, so [0, 1.5)
    found = largest_proved(first_order(), 0.0)
    assert found.grade == "certificate"
    assert 1.5 * (1 - 2e-5) < found.limit < 1.5
    assert prove("circle", first_order(), 0.0, 1.5000001).grade == "refused"


def test_the_continuous_limits_are_the_ones_worked_by_hand():
    # G = 1/(s + 1)^3: Re G = (1 - 3 w^2)/(1 + w^2)^3, smallest -1/4 at w = 1; Popov goes up to the Nyquist limit of 8
    loop = continuous_loop([1.0], [1.0], [1.0], [1.0, 3.0, 3.0, 1.0])
    assert largest_proved(loop, 0.0).limit == pytest.approx(4.0, rel=1e-4)
    popov = largest_proved(loop, 0.0, "popov")
    assert popov.grade == "certificate" and 7.98 < popov.limit < 8.0
    assert prove("popov", loop, 0.0, 8.001).grade == "refused"
    assert prove("popov", loop, 0.0, 5.0).multiplier > 0.0


def test_the_main_loop_is_proved_for_the_sector_of_the_digest(star):
    found = largest_proved(star, 1.0)
    assert found.grade == "certificate" and found.limit == pytest.approx(2.265, rel=5e-3)
    assert found.limit == pytest.approx(ask("circle", star, 1.0).limit, rel=2e-5)
    assert largest_proved(star, 1e-5).limit == pytest.approx(0.697, rel=5e-3)
    assert "double precision" in found.statement and "rounding" in found.statement


def test_the_proof_covers_more_than_the_rounding_of_the_matrix_exponential(star):
    found = prove("circle", star, 1.0, 2.2)
    assert found.data["tolerance"] > ROUNDING
    assert _worst_rounding_of_the_plant() < 0.1 * ROUNDING


def _worst_rounding_of_the_plant():
    """Relative error of the XY table's hold in doubles, against the exponential's series in fractions."""
    from leadscrew.plants._linear import hold_matrices

    worst = Fraction(0)
    for dt in (5e-4, 2.75e-4, 2.25e-4):
        joined = np.zeros((3, 3))
        joined[0, 1], joined[1, :2], joined[1, 2] = 1.0, (-166.3, -144.8), 1.0
        exact = rational(joined) * Fraction(dt)
        term = total = rational(np.eye(3))
        for n in range(1, 30):
            term = term.dot(exact) / n
            total = total + term
        found = hold_matrices(joined[:2, :2], joined[:2, 2], dt)
        for got, true in zip((*found[0].ravel(), *found[1]), (*total[:2, :2].ravel(), *total[:2, 2]), strict=True):
            worst = max(worst, abs(Fraction(float(got)) - true) / abs(true))
    return float(worst)


def test_the_same_function_proves_loops_that_differ_by_the_tolerance(star):
    found = prove("circle", star, 1.0, 2.2)
    part, draw = found.data["tolerance"], np.random.default_rng(3)
    for _ in range(3):
        moved = [m * (1.0 + part * draw.choice([-1.0, 1.0], size=m.shape)) for m in (star.a, star.b, star.c, star.d)]
        assert proved(inequality(LinearLoop(*moved, star.dt), 1.0, 2.2), found.data["p"]) is not None


def test_the_function_of_the_proof_falls_whatever_gain_in_the_sector_is_taken(star):
    p = prove("circle", star, 1.0, 2.2).data["p"]
    draw = np.random.default_rng(5)
    root = np.linalg.inv(np.linalg.cholesky(p)).T
    for _ in range(2000):
        x = root @ draw.normal(size=len(p))
        gain = draw.choice([1.0, 2.2, draw.uniform(1.0, 2.2)])
        after = star.a @ x - gain * star.b[:, 0] * (star.c[0] @ x)
        assert after @ p @ after < x @ p @ x


def test_a_matrix_that_proves_nothing_is_not_taken(star):
    p = prove("circle", star, 1.0, 2.2).data["p"]
    assert proved(inequality(star, 1.0, 2.2), p) is not None
    assert proved(inequality(star, 1.0, 2.3), p) is None
    assert proved(inequality(star, 1.0, 2.2), -p) is None
    assert proved(inequality(star, 1.0, 2.2), np.eye(len(p))) is None


@pytest.mark.parametrize(("name", "k1"), [("L_star", 1.0), ("L0", 1.0), ("L_star", 1e-3)])
def test_tsypkin_proves_what_its_frequency_condition_promises_and_more_than_the_circle(name, k1):
    loop = reference_loops()[name]
    found, checked = largest_proved(loop, k1, "tsypkin"), ask("tsypkin", loop, k1)
    assert found.grade == "certificate"
    assert found.limit == pytest.approx(checked.limit, rel=5e-4)
    assert found.limit > 1.01 * largest_proved(loop, k1).limit


def test_a_bound_of_the_slope_proves_more_than_none(star):
    slope = math.cosh(1.5) + 1.5 * math.sinh(1.5)
    free = largest_proved(star, 1.0, "tsypkin").limit
    bound = largest_proved(star, 1.0, "tsypkin", (1.0, slope)).limit
    assert free < bound < star.gain_limit()
    assert prove("best", star, 1.0, 2.33, (1.0, slope)).grade == "certificate"
    assert prove("best", star, 1.0, 2.33).grade == "refused"


def test_jury_lee_proves_gentle_laws_in_a_sector_beyond_the_circle(star):
    gentle = (0.001, 0.8)
    found = prove("jury-lee", star, 0.001, 0.75, gentle)
    assert found.grade == "certificate" and found.multiplier != 0.0
    assert prove("circle", star, 0.001, 0.75).grade == "refused"


def test_the_papers_law_is_proved_at_rest_by_a_multiplier_that_remembers_six_errors(star):
    gain, slope = math.cosh(1.5), math.cosh(1.5) + 1.5 * math.sinh(1.5)
    found = prove("zames-falb", star, 1.0, gain + 1e-6, (1.0, slope + 1e-6))
    assert found.grade == "certificate" and found.data["tolerance"] > ROUNDING
    assert prove("zames-falb", star, 1.0, gain, (1.0, slope), taps=1).grade == "refused"
    assert prove("zames-falb", star, 1.0, 2.52, (1.0, slope)).grade == "refused"
    one = largest_proved(star, 1.0, "tsypkin", (1.0, slope)).limit  # one delay is Tsypkin's multiplier
    assert prove("zames-falb", star, 1.0, 0.999 * one, (1.0, slope), taps=1).grade == "certificate"
    assert prove("zames-falb", star, 1.0, 1.001 * one, (1.0, slope), taps=1).grade == "refused"


def test_the_remembering_multiplier_is_what_the_inequality_says_at_every_frequency(star):
    weights, taps, k2, slope = np.array([0.3, 0.0, 0.2, 0.1, 0.0, 0.4, 0.05, 0.0]), 2, 2.0, 4.0
    lmi = zames_falb_inequality(star, 1.0, k2, weights, taps, slope)
    z, y, s, n = lmi.z.astype(float), lmi.y.astype(float), lmi.s.astype(float), lmi.order
    for w in (3.0, 400.0, 1200.0, 6000.0):
        turn = np.exp(1j * w * star.dt)
        states = np.linalg.solve(turn * np.eye(n) - z[:, :n], z[:, n:])
        signals = y @ np.vstack([states, [[1.0]]])
        g1 = star.shifted(1.0).response(w)
        delays = np.array([-2, -1, 1, 2])
        m = weights[:4] @ (1.0 - turn**-delays) + weights[4:] @ (1.0 + turn**-delays)
        late = signals[1, 0] - signals[0, 0]  # w = v - k1 e
        expected = -2.0 * (((1.0 + m) * g1).real + 1.0 + m.real / (slope - 1.0)) * abs(late) ** 2
        assert (signals.conj().T @ s @ signals)[0, 0].real == pytest.approx(expected, rel=1e-8)


def test_resonators_on_the_unit_circle_are_no_obstacle_to_a_proof():
    from leadscrew.studies.npid_xytable.rejection import opened
    from leadscrew.studies.npid_xytable.tunings import TUNINGS

    loop = opened(TUNINGS["ours.resonant"])
    assert len(loop.a) == 18 and np.abs(np.linalg.eigvals(loop.a)).max() > 1.0 - 1e-9
    found = largest_proved(loop, 1.0)
    assert found.grade == "certificate" and found.limit == pytest.approx(2.266, rel=1e-3)
    assert loop.stable(found.limit) and not loop.stable(1.2 * found.limit)


def test_a_continuous_loop_with_dead_time_is_referred_to_the_sampled_one():
    late = reference_loops()["Lc"]
    for found in (prove("circle", late, 1.0, 1.5), prove("popov", late, 1.0, 1.5), largest_proved(late, 1.0)):
        assert found.grade == "refused" and "sampled" in found.statement and "1.2888 ms" in found.statement


def test_what_cannot_be_proved_is_refused_in_a_sentence(star):
    integrating = prove("circle", star, 0.0, 0.5)
    assert integrating.grade == "refused" and "integrator needs k1 > 0" in integrating.statement
    beyond = prove("circle", star, 1.0, 2.6)
    assert beyond.grade == "refused" and "2.51 makes it unstable" in beyond.statement and "2.265" in beyond.statement
    assert beyond.margin == pytest.approx(2.265 / 2.6, rel=1e-3)
    unstable = prove("circle", star, 3.0, 4.0)
    assert unstable.grade == "refused" and "not asymptotically stable" in unstable.statement


def test_questions_without_sense_are_refused_at_the_door(star):
    for k1, k2 in ((1.0, math.inf), (2.0, 1.0), (math.nan, 1.0)):
        with pytest.raises(ValueRefused, match="sector"):
            prove("circle", star, k1, k2)
    with pytest.raises(ValueRefused, match="slope"):
        prove("tsypkin", star, 1.0, 2.0, (0.5, 3.0))
    with pytest.raises(ValueRefused, match="sampled"):
        prove("best", reference_loops()["no_delay"], 1.0, 2.0)
    with pytest.raises(ValueRefused, match="continuous"):
        prove("popov", star, 1.0, 2.0)


def test_the_driven_loop_is_proved_by_its_slope_and_not_by_its_gain(star):
    ours = driven(star, (1.0, 2.2))
    assert ours.grade == "certificate" and "no constant load makes a limit cycle" in ours.statement
    assert ours.limit == pytest.approx(2.265, rel=5e-3) and ours.margin == pytest.approx(2.265 / 2.2, rel=1e-3)
    paper = driven(star, (1.0, 5.5463))
    assert paper.grade == "refused" and "Nyquist limit" in paper.statement
    assert driven(star, (1.0, 2.2), factor=1.1).grade == "refused"
    assert driven(star, (1.0, 1.0)).grade == "certificate"


def test_a_driven_loop_with_dead_time_is_only_checked_on_a_grid():
    late = reference_loops()["Lc"]
    found = driven(late, (1.0, 2.2))
    assert found.grade == "grid-checked" and found.limit == pytest.approx(2.270, rel=5e-3)
    assert any("no proof" in w for w in found.warnings)
    assert driven(late, (1.0, 2.3)).grade == "refused"


@pytest.mark.slow
def test_two_starts_converge_on_a_ramp_where_it_is_proved_and_the_paper_chatters_there(star):
    def apart(block):
        law = lure(block)
        states, gaps = np.zeros((2, len(star.a))), []
        states[1] = 1e-3 * np.linalg.pinv(star.c)[:, 0]
        for n in range(3000):  # 2.2 mm/s: a following error of 2.6 to 7 um under Table I
            e = 2.2 * n * star.dt - states @ star.c[0]
            gaps.append(abs(e[1] - e[0]))
            states = states @ star.a.T + np.outer(law.curve(e), star.b[:, 0])
        return max(gaps[-500:])

    assert driven(star, lure(npid_slope(k=2.2)).slope_sector).grade == "certificate"
    assert apart(npid_slope(k=2.2)) < 1e-9
    assert driven(star, lure(npid).slope_sector).grade == "refused"
    assert apart(npid) > 1e-4


def test_the_plot_shows_the_disc_and_the_grade(star):
    drawn = driven(star, (1.0, 2.2)).figure()
    assert "certificate" in drawn.axes[0].get_title()
    assert drawn.axes[0].patches
