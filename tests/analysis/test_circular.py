"""The circular test: least-squares circle, ISO 230-4 quantities, editions, reversals, instrument."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import least_squares

from leadscrew.analysis.circular.paths import CircularTest, Turn, least_squares_circle
from leadscrew.analysis.circular.quantities import named, quantities
from leadscrew.analysis.circular.reversals import reversals
from leadscrew.analysis.circular.synthetic import AxisErrors, BallBar, MachineErrors, circle_with, read_by
from leadscrew.util.errors import DataError, ValueRefused

NM = 0.001
"""In um: what the analytic cases must keep."""
PHI = 2.0 * np.pi * np.arange(1800) / 1800


def made(ccw, cw, radius=100.0, **more):
    """A test from two functions of the angle of travel that give x and y in mm, written down here and nowhere else."""
    turns = [Turn(d, *f(s * PHI)) for d, f, s in (("ccw", ccw, 1), ("cw", cw, -1))]
    return CircularTest(radius, *turns, **more)


def same(path, **more):
    return made(path, path, **more)


# ---- the circle
@pytest.mark.parametrize("seed", range(4))
def test_the_circle_is_the_one_that_scipy_finds(seed):
    random = np.random.default_rng(seed)
    angle = random.uniform(0.0, 2.0 + seed, 60)
    x = 3.0 + 50.0 * np.cos(angle) + random.normal(0.0, 0.5, 60)
    y = -7.0 + 50.0 * np.sin(angle) + random.normal(0.0, 0.5, 60)
    found = least_squares_circle(x, y)
    other = least_squares(lambda p: np.hypot(x - p[0], y - p[1]) - p[2], (0.0, 0.0, 40.0), xtol=1e-15, ftol=1e-15)
    assert found == pytest.approx(tuple(other.x), abs=1e-6)


def test_the_circle_of_points_on_a_circle_is_that_circle_far_from_zero_too():
    found = least_squares_circle(1e5 + 0.001 * np.cos(PHI), -2e5 + 0.001 * np.sin(PHI))
    assert found.radius == pytest.approx(0.001, abs=1e-9) and found.x == pytest.approx(1e5, abs=1e-9)


@pytest.mark.parametrize(
    ("x", "y", "said"),
    [([0, 1], [0, 1], "2 points"), ([0, 1, 2], [0, 1, 2], "line"), ([1, 1, 1], [2, 2, 2], "same"),
     ([0, 1, math.nan], [0, 1, 5], "finite"), ([0, 1, 2], [0, 1], "shapes")],
)  # fmt: skip
def test_points_that_make_no_circle_are_refused(x, y, said):
    with pytest.raises(DataError, match=said):
        least_squares_circle(x, y)


# ---- analytic cases, to 1 nm; R = 100 mm
def test_squareness_of_10_urad_gives_1_um():
    found = quantities(same(lambda p: (100 * np.cos(p) + 1e-5 * 100 * np.sin(p), 100 * np.sin(p))))
    assert found.ccw.circular == pytest.approx(1.0, abs=NM) == found.cw.circular
    assert found.both.circular == pytest.approx(1.0, abs=NM)
    assert found.both.hysteresis == pytest.approx(0.0, abs=NM)


def test_a_bow_of_2_um_gives_1_um():
    found = quantities(same(lambda p: (100 * np.cos(p), 100 * np.sin(p) + 0.002 * np.cos(p) ** 2)))
    assert found.ccw.circular == pytest.approx(1.0, abs=NM)
    # The bow moves the circle by half of itself times the mean of sin^2.
    assert found.ccw.centre_y == pytest.approx(0.5, abs=NM)


def test_cyclic_error_of_1_um_at_a_lead_of_10_005_mm():
    def path(p):
        x = 100 * np.cos(p)
        return x + 0.001 * np.sin(2 * np.pi * x / 10.005), 100 * np.sin(p)

    found = quantities(same(path))
    assert found.ccw.circular == pytest.approx(1.901, abs=NM)
    assert found.both.mean_radial == pytest.approx(-0.073, abs=NM)
    # To first order the mean radius changes by the mean of sin(z cos p) cos p, a Bessel function of the first kind.
    from scipy.special import j1

    assert found.both.mean_radial == pytest.approx(j1(2 * np.pi * 100 / 10.005), abs=NM)


def test_scale_of_minus_10_ppm_is_only_in_the_mean_radius():
    found = quantities(same(lambda p: (100 * (1 - 1e-5) * np.cos(p), 100 * (1 - 1e-5) * np.sin(p))))
    assert found.both.mean_radial == pytest.approx(-1.0, abs=NM)
    assert found.both.circular == pytest.approx(0.0, abs=NM)
    assert (found.ccw.largest, found.ccw.smallest) == pytest.approx((-1.0, -1.0), abs=NM)


def dead_band(p, sign, at_rest):
    """Play of 2 um on both axes; ``at_rest`` is the side on which a point exactly at a reversal counts."""

    def way(v):
        return np.where(np.abs(v) < 1e-12, at_rest, np.sign(v))

    return 100 * np.cos(p) - 0.001 * way(-sign * np.sin(p)), 100 * np.sin(p) - 0.001 * way(sign * np.cos(p))


def test_a_dead_band_of_2_um_with_points_on_both_sides_of_each_reversal():
    angles = np.sort(np.concatenate([PHI + 1e-8, PHI + 2 * np.pi / 1800 - 1e-8]))
    turns = [Turn(d, *dead_band(s * angles, s, 0.0)) for d, s in (("ccw", 1), ("cw", -1))]
    found = quantities(CircularTest(100.0, *turns))
    assert found.ccw.circular == pytest.approx(2.0, abs=NM)
    assert found.both.circular == pytest.approx(2.0, abs=NM)
    assert found.both.hysteresis == pytest.approx(2.0, abs=NM)
    assert found.both.mean_radial == pytest.approx(0.0, abs=NM)


@pytest.mark.parametrize("at_rest", [-1.0, 0.0, 1.0])
def test_1800_points_a_turn_miss_up_to_7_nm_of_a_dead_band_and_no_more(at_rest):
    """The next point is 0.2 degree past the reversal: cos 0.2 - sin 0.2 = 0.99650 instead of 1, on one side or both."""
    turns = [Turn(d, *dead_band(s * PHI, s, at_rest)) for d, s in (("ccw", 1), ("cw", -1))]
    found = quantities(CircularTest(100.0, *turns))
    past = math.cos(math.radians(0.2)) - math.sin(math.radians(0.2))
    assert 2.0 * past - NM < found.ccw.circular < 2.0 + NM
    assert 2.0 * past - NM < found.both.hysteresis < 2.0 + NM


# ---- what the quantities mean
def test_a_circle_that_is_only_off_centre_is_round():
    found = quantities(same(lambda p: (100 * np.cos(p) + 0.005, 100 * np.sin(p) - 0.003)))
    assert found.ccw.circular == pytest.approx(0.0, abs=NM)
    assert (found.ccw.centre_x, found.ccw.centre_y) == pytest.approx((5.0, -3.0), abs=NM)
    assert found.ccw.set_up_largest == pytest.approx(math.hypot(5, 3), abs=NM)
    assert found.ccw.largest == pytest.approx(0.0, abs=NM)


def test_two_round_circles_of_different_radius_differ_in_both_directions_only():
    found = quantities(
        made(lambda p: (100.002 * np.cos(p), 100.002 * np.sin(p)), lambda p: (100 * np.cos(p), 100 * np.sin(p)))
    )
    assert found.ccw.circular == pytest.approx(0.0, abs=NM) == found.cw.circular
    assert found.both.circular == pytest.approx(2.0, abs=NM)
    assert found.both.hysteresis == pytest.approx(2.0, abs=NM)
    assert found.both.mean_radial == pytest.approx(1.0, abs=NM)


def test_editions_have_their_quantities_and_names():
    found = quantities(circle_with(MachineErrors(squareness_urad=10.0), 100.0))
    symbols = {e: {n.symbol for n in named(found, e)} for e in ("1996", "2005", "2022")}
    assert "H_XY" in symbols["1996"] and not any(s.startswith(("G(b)", "D")) for s in symbols["1996"])
    assert {"G(b)_XY", "D_XY"} <= symbols["2005"] and "H_XY" not in symbols["2005"]
    assert symbols["2005"] == symbols["2022"]
    assert all("deviation" in n.name for n in named(found, "2005"))
    assert all("error" in n.name and "deviation" not in n.name for n in named(found, "2022"))
    assert named(found, "2022", ("Z", "X"))[0].symbol == "G(b)_ZX"
    with pytest.raises(ValueRefused, match="1996, 2005, 2022"):
        named(found, "2010")


# ---- what is no circular test
@pytest.mark.parametrize("radius", [0.0, -1.0, math.nan, math.inf])
def test_a_radius_that_is_none_is_refused(radius):
    turn = Turn("ccw", 100 * np.cos(PHI), 100 * np.sin(PHI))
    with pytest.raises(ValueRefused, match="expected a positive number"):
        CircularTest(radius, turn, None)


def turn_of(angles, direction="ccw", radius=100.0):
    return Turn(direction, radius * np.cos(angles), radius * np.sin(angles))


def test_less_than_a_full_turn_two_points_and_swapped_axes_are_refused_with_what_they_are():
    with pytest.raises(DataError, match=r"cover 300\.0 degrees; expected a full turn"):
        turn_of(np.radians(np.arange(0.0, 300.1, 0.2)))
    with pytest.raises(DataError, match="2 points; a circle needs at least 36"):
        turn_of(np.array([0.0, 1.0]))
    with pytest.raises(DataError, match="are the axes x and y swapped"):
        Turn("ccw", 100 * np.sin(PHI), 100 * np.cos(PHI))
    with pytest.raises(DataError, match="point 3 is not finite"):
        Turn("ccw", np.where(np.arange(1800) == 2, np.nan, 100 * np.cos(PHI)), 100 * np.sin(PHI))
    with pytest.raises(DataError, match="expected one direction or both"):
        CircularTest(100.0, None, None)


def test_a_circle_of_another_size_or_elsewhere_is_refused():
    with pytest.raises(DataError, match=r"radius of 100 mm where the nominal one is 50 mm"):
        CircularTest(50.0, turn_of(PHI), None)
    moved = Turn("ccw", 100 * np.cos(PHI) + 30.0, 100 * np.sin(PHI))
    with pytest.raises(DataError, match=r"lies around \(30, .*give the centre"):
        CircularTest(100.0, moved, None)


def test_encoder_circles_and_single_directions_are_said_so():
    test = CircularTest(100.0, turn_of(PHI), None, source="encoder")
    said = " ".join(test.notes())
    assert "encoder signals: what the control sees, not the path of the tool" in said
    assert "counter-clockwise only" in said and "cannot be distinguished" in said


# ---- reversals
def test_a_quadrant_glitch_has_its_height_and_its_time():
    faults = MachineErrors(y=AxisErrors(stick_um=3.0, stick_rise_deg=1.0, stick_decay_deg=1.0))
    found = reversals(circle_with(faults, 100.0, points=18000, feed_mm_min=1000.0))
    assert [(r.axis, r.end, r.direction) for r in found[:4]] == [
        ("X", "+", "ccw"), ("Y", "+", "ccw"), ("X", "-", "ccw"), ("Y", "-", "ccw")
    ]  # fmt: skip
    for r in found:
        if r.axis == "Y":
            assert r.height_um == pytest.approx(3.0, rel=0.001)
            # Rise of 1 degree, then down to a tenth in ln 10 decays; a degree takes R pi / 180 / feed.
            assert r.duration_deg == pytest.approx(1.0 + math.log(10.0), abs=0.05)
            assert r.duration_s == pytest.approx(r.duration_deg * 100.0 * math.pi / 180.0 / (1000.0 / 60.0))
        else:
            assert not r.seen


def test_play_is_a_step_with_its_sign_at_its_end_and_no_glitch():
    faults = MachineErrors(
        x=AxisErrors(backlash_plus_um=2.0, backlash_minus_um=3.0, scale_ppm=20.0),
        y=AxisErrors(backlash_plus_um=-1.0, backlash_minus_um=-1.0),
        squareness_urad=30.0, centre_x_um=20.0,
    )  # fmt: skip
    steps = {(r.axis + r.end): r.step_um for r in reversals(circle_with(faults, 100.0)) if r.direction == "cw"}
    assert steps["X-"] == pytest.approx(3.0, abs=0.06) and steps["X+"] == pytest.approx(2.0, abs=0.06)
    assert steps["Y+"] == pytest.approx(-1.0, abs=0.06) and steps["Y-"] == pytest.approx(-1.0, abs=0.06)


# ---- the instrument
def test_an_ideal_bar_reads_the_true_path():
    test = circle_with(MachineErrors(squareness_urad=10.0, x=AxisErrors(cyclic_um=1.0, lead_mm=10.005)), 100.0)
    ideal = BallBar(resolution_um=0.0, sphericity_um=0.0)
    read, true = quantities(read_by(ideal, test)), quantities(test)
    assert read.both.circular == pytest.approx(true.both.circular, abs=NM)
    assert read.both.mean_radial == pytest.approx(true.both.mean_radial, abs=NM)


def test_balls_resolution_and_centring_show_in_the_reading_by_as_much_as_they_are():
    round_circle = circle_with(MachineErrors(), 100.0)
    balls = quantities(read_by(BallBar(resolution_um=0.0), round_circle))
    assert 0.02 < balls.ccw.circular <= 0.1 + NM
    steps = read_by(BallBar(sphericity_um=0.0, centring_x_um=3.0), round_circle)
    readings = steps.ccw.deviation_um(100.0)
    assert np.abs(readings / 0.1 - np.round(readings / 0.1)).max() < 1e-6
    assert quantities(steps).ccw.centre_x == pytest.approx(-3.0, abs=0.01)
    assert quantities(steps).ccw.circular < 0.25
    longer = quantities(read_by(BallBar(0.0, 0.0, length_error_um=0.7), round_circle))
    assert longer.both.mean_radial == pytest.approx(0.7, abs=NM)


def test_the_same_seed_gives_the_same_balls_and_bad_values_are_refused():
    test = circle_with(MachineErrors(), 100.0)
    one, same_one, other = (read_by(BallBar(resolution_um=0.0, seed=s), test).ccw.x_mm for s in (1, 1, 2))
    assert (one == same_one).all() and (one != other).any()
    with pytest.raises(ValueRefused, match="resolution_um"):
        read_by(BallBar(resolution_um=-0.1), test)
    with pytest.raises(ValueRefused, match="at most 10"):
        read_by(BallBar(step_deg=30.0), test)
