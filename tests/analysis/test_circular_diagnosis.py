"""The diagnosis: every fault comes back as large as it was made, alone and with all others."""

from __future__ import annotations

import math

import numpy as np
import pytest

from leadscrew.analysis.circular.diagnosis import diagnose
from leadscrew.analysis.circular.paths import CircularTest, Turn
from leadscrew.analysis.circular.synthetic import AxisErrors, MachineErrors, circle_with
from leadscrew.util.errors import DataError
from tests.budget import in_every_run

FEED = 1000.0
X = AxisErrors(
    lag_um=104.0, scale_ppm=-10.0, backlash_plus_um=2.0, backlash_minus_um=3.0, straightness_um=2.0, cyclic_um=1.0,
    lead_mm=10.005, cyclic_phase_rad=0.5, stick_um=3.0, stick_rise_deg=1.2, stick_decay_deg=2.1, slip_um=1.0,
)  # fmt: skip
Y = AxisErrors(
    lag_um=100.0, scale_ppm=20.0, backlash_plus_um=5.0, backlash_minus_um=4.0, straightness_um=-3.0, cyclic_um=0.7,
    lead_mm=5.0, cyclic_phase_rad=1.0, stick_um=2.0, slip_um=1.3, slip_period_deg=2.1, slip_zone_deg=11.0,
)  # fmt: skip
ALL = MachineErrors(X, Y, squareness_urad=30.0, centre_x_um=4.0, centre_y_um=-7.0)
PLAIN = AxisErrors()


def only(**names):
    """The machine with only these faults of ALL: ``x`` and ``y`` name fields of the axes."""
    parts = {
        axis: PLAIN._replace(**{f: getattr(getattr(ALL, axis), f) for f in names.get(axis, ())}) for axis in ("x", "y")
    }
    return MachineErrors(**parts, **{k: getattr(ALL, k) for k in names.get("machine", ())})


def expected(errors, radius=100.0):
    """Every fault in um, by the names of the diagnosis."""
    found = {
        "squareness": 1e-3 * errors.squareness_urad * radius,
        "servo mismatch": errors.x.lag_um - errors.y.lag_um,
    }
    for name, axis in (("X", errors.x), ("Y", errors.y)):
        found |= {
            f"scale {name}": 1e-3 * axis.scale_ppm * radius, f"straightness {name}": axis.straightness_um,
            f"backlash {name}+": axis.backlash_plus_um, f"backlash {name}-": axis.backlash_minus_um,
            f"cyclic error {name}": axis.cyclic_um, f"stick motion {name}": axis.stick_um,
            f"stick-slip {name}": axis.slip_um,
        }  # fmt: skip
    return found


def assert_all_come_back(errors, test=None):
    found = diagnose(test or circle_with(errors, 100.0, feed_mm_min=FEED))
    for name, size in expected(errors).items():
        assert abs(found[name].um - size) <= max(0.02 * abs(size), 0.05), (name, size, found[name])
    return found


ONE_AT_A_TIME = {
    "squareness": only(machine=("squareness_urad",)),
    "scale": only(x=("scale_ppm",), y=("scale_ppm",)),
    "servo mismatch": only(x=("lag_um",), y=("lag_um",)),
    "backlash": only(x=("backlash_plus_um", "backlash_minus_um"), y=("backlash_plus_um", "backlash_minus_um")),
    "straightness": only(x=("straightness_um",), y=("straightness_um",)),
    "cyclic error": only(x=("cyclic_um", "lead_mm", "cyclic_phase_rad")),
    "stick motion": only(x=("stick_um", "stick_rise_deg", "stick_decay_deg")),
    "stick-slip": only(y=("slip_um", "slip_period_deg", "slip_zone_deg")),
    "nothing": MachineErrors(),
    "only off centre": MachineErrors(centre_x_um=20.0, centre_y_um=30.0),
}


@pytest.mark.parametrize("name", in_every_run(ONE_AT_A_TIME, set(ONE_AT_A_TIME) - {"stick-slip"}))
def test_one_fault_comes_back_and_no_other_appears(name):
    assert_all_come_back(ONE_AT_A_TIME[name])


@pytest.mark.slow
def test_the_faults_of_the_acceptance_all_together():
    """Backlash, squareness, scale and servo mismatch, straightness, cyclic error; the smooth machine of ALL."""
    smooth = ALL._replace(x=X._replace(stick_um=0.0, slip_um=0.0), y=Y._replace(stick_um=0.0, slip_um=0.0))
    found = assert_all_come_back(smooth)
    assert found["cyclic error X"].more["lead_mm"] == pytest.approx(10.005, rel=1e-3)
    assert found["cyclic error X"].more["phase_rad"] == pytest.approx(0.5, abs=0.01)
    assert found["squareness"].more["urad"] == pytest.approx(30.0, abs=0.1)
    # 4 um at 1,000 mm/min.
    assert found["servo mismatch"].more["ms"] == pytest.approx(0.24, abs=0.001)
    assert found.left_rms_um < 0.005 and found.condition < 10.0 and found.together == []


@pytest.mark.slow
def test_all_eight_kinds_on_both_axes_together():
    found = assert_all_come_back(ALL)
    assert found["stick motion X"].more["rise_deg"] == pytest.approx(1.2, rel=0.02)
    assert found["stick-slip Y"].more["period_deg"] == pytest.approx(2.1, rel=0.02)


def test_a_circle_written_down_here_comes_back_too():
    """Not by the module of known faults: sign of the motion by difference, errors put on one by one."""
    angle = 2.0 * np.pi * np.arange(1800) / 1800
    turns = []
    for direction, sign in (("ccw", 1.0), ("cw", -1.0)):
        phi = sign * angle
        x, y = 80.0 * np.cos(phi), 80.0 * np.sin(phi)
        way = np.sign(np.roll(x, -1) - np.roll(x, 1))
        bent = x + 12e-6 * y - 0.5 * 0.004 * way
        turns.append(Turn(direction, bent, y + 0.0015 * (x / 80.0) ** 2 + 15e-6 * y))
    found = diagnose(CircularTest(80.0, *turns))
    wanted = {"squareness": 0.96, "backlash X+": 4.0, "backlash X-": 4.0, "straightness X": 1.5, "scale Y": 1.2}
    for fault in found.ranked():
        assert fault.um == pytest.approx(wanted.get(fault.name, 0.0), abs=0.002), fault


def test_one_direction_cannot_tell_squareness_from_servo_mismatch_and_says_how_much_either_would_be():
    errors = only(machine=("squareness_urad",), x=("backlash_plus_um", "backlash_minus_um"))
    found = diagnose(circle_with(errors, 100.0, directions="ccw"))
    assert found["squareness"].um is None and found["servo mismatch"].um is None
    assert found["backlash X-"].um == pytest.approx(3.0, abs=0.05)
    (pair,) = found.together
    assert pair.alone_um == pytest.approx({"squareness": 3.0, "servo mismatch": 3.0}, abs=0.01)
    assert "cannot be distinguished" in str(pair)
    clockwise = diagnose(circle_with(errors, 100.0, directions="cw")).together[0]
    assert clockwise.alone_um["servo mismatch"] == pytest.approx(-3.0, abs=0.01)


def test_a_known_lead_is_taken_and_one_that_the_points_cannot_show_is_refused():
    test = circle_with(only(x=("cyclic_um", "lead_mm")), 100.0)
    found = diagnose(test, leads_mm=(10.005, None))
    assert found["cyclic error X"].um == pytest.approx(1.0, abs=0.001)
    assert found["cyclic error X"].more["lead_mm"] == pytest.approx(10.005)
    for lead in (0.1, 200.0, -5.0, math.nan):
        with pytest.raises(DataError, match="these points show cyclic errors from"):
            diagnose(test, leads_mm=(lead, None))


def noisy(test, sigma_um, seed):
    random = np.random.default_rng(seed)
    turns = []
    for t in test.turns:
        grown = 1.0 + 1e-3 * sigma_um / test.radius_mm * random.normal(size=t.x_mm.size)
        turns.append(Turn(t.direction, t.x_mm * grown, t.y_mm * grown))
    return CircularTest(test.radius_mm, *turns, feed_mm_min=FEED)


@pytest.mark.slow
def test_stated_uncertainties_are_those_of_a_monte_carlo():
    errors = only(machine=("squareness_urad",), x=("backlash_plus_um", "backlash_minus_um", "scale_ppm"))
    plain = circle_with(errors, 100.0)
    runs = [diagnose(noisy(plain, 0.5, seed), floor_um=5.0) for seed in range(120)]
    for name, size in expected(errors).items():
        if name.startswith(("cyclic", "stick")):
            continue
        values = np.array([r[name].um for r in runs])
        stated = np.mean([r[name].uncertainty_um for r in runs])
        # The scatter of 120 runs is known to 1 / sqrt(240) = 6.5 %; four times that.
        assert np.std(values, ddof=1) == pytest.approx(stated, rel=0.26), name
        assert abs(values.mean() - size) < 4.0 * stated / math.sqrt(120) + 0.001, name


@pytest.mark.slow
def test_all_faults_under_scatter_lie_within_what_is_stated():
    plain = circle_with(ALL._replace(x=X._replace(slip_um=0.0), y=Y._replace(slip_um=0.0)), 100.0)
    misses, count = 0, 0
    for seed in range(6):
        found = diagnose(noisy(plain, 0.05, seed))
        for name, size in expected(ALL).items():
            if not name.startswith("stick-slip"):
                fault = found[name]
                misses += abs(fault.um - size) > 3.0 * fault.uncertainty_um + 0.002
                count += 1
    assert misses <= 0.03 * count


def test_what_no_signature_explains_is_what_is_left():
    def path(phi):
        bump = 0.002 * np.exp(-(((np.mod(phi, 2 * np.pi) - 2.2) / 0.05) ** 2))
        return (100.0 + bump) * np.cos(phi), (100.0 + bump) * np.sin(phi)

    angle = 2.0 * np.pi * np.arange(1800) / 1800
    found = diagnose(CircularTest(100.0, Turn("ccw", *path(angle)), Turn("cw", *path(-angle))), floor_um=5.0)
    assert found.left_peak_um > 1.0 and np.argmax(found.left[0]) == pytest.approx(2.2 / angle[1], abs=20)


@pytest.mark.slow
def test_a_peak_of_one_point_has_a_size_with_a_sound_uncertainty():
    """Its decay cannot be seen: it ends at the shortest one, and takes no part in the uncertainty."""
    angle = 2.0 * np.pi * np.arange(1800) / 1800
    random = np.random.default_rng(1)

    def turn(direction, sign):
        after = np.mod(sign * (sign * angle - 0.5 * np.pi) + 1e-9, np.pi) - 1e-9
        radius = 5.0 + 5e-5 * ((after > 0.003) & (after < 0.004)) + random.normal(0.0, 3e-6, angle.size)
        return Turn(direction, radius * np.cos(sign * angle), radius * np.sin(sign * angle))

    found = diagnose(CircularTest(5.0, turn("ccw", 1.0), turn("cw", -1.0)))["stick motion Y"]
    assert found.um is not None and abs(found.um) > 0.03
    assert found.uncertainty_um < 0.02


@pytest.mark.slow
def test_the_last_digits_of_a_diagnosis_do_not_change_with_the_threads_of_the_linear_algebra():
    import scipy.linalg  # noqa: F401  its BLAS has threads of its own
    from threadpoolctl import threadpool_limits

    test = circle_with(ALL, 100.0, feed_mm_min=FEED)
    found = []
    for threads in (1, 4):
        with threadpool_limits(threads):
            found.append([(f.um, f.uncertainty_um) for f in diagnose(test, (10.005, 5.0)).faults])
    assert found[0] == found[1]


def test_a_diagnosis_computes_on_one_thread_whatever_the_machine_has(monkeypatch):
    from threadpoolctl import threadpool_info

    class Seen(Exception):
        pass

    def searched(*_, **__):
        raise Seen({p["num_threads"] for p in threadpool_info() if p["user_api"] == "blas"})

    monkeypatch.setattr("leadscrew.analysis.circular.diagnosis.searched", searched)
    with pytest.raises(Seen, match=r"^\{1\}$"):
        diagnose(circle_with(only(x=("backlash_plus_um",)), 100.0))
