"""Table II from simulation: the calibration, the compression law, trials over phases and plants."""

import numpy as np
import pytest

from leadscrew.controllers._npid import npid, scaled_error
from leadscrew.studies.npid_xytable.calibration import gain_um_per_mv, responses
from leadscrew.studies.npid_xytable.cutting import BOX, amplitudes_um, phases_of, spindle_lines_hz, tried
from leadscrew.studies.npid_xytable.laws import (
    FITTED,
    misfit_um,
    npid_rows,
    of_the_disturbance,
    refitted,
    uncompressed,
)
from leadscrew.studies.npid_xytable.table2 import LINES_HZ, NPID_UM, PID_UM
from tests.studies.npid_lab import lab

TABLE = lab().study


def test_a_millivolt_moves_the_axis_by_three_quarters_of_a_micrometre():
    by_hand = (0.75471, 0.75208, 0.74818, 0.74309, 0.73687)
    assert [gain_um_per_mv(f) for f in LINES_HZ] == pytest.approx(by_hand, abs=1e-5)


def test_the_closed_form_is_what_a_simulation_does():
    run = lab().run("paper.pid", "spindle_2000")
    assert amplitudes_um(run) == pytest.approx(PID_UM[2000], abs=1e-4)
    assert amplitudes_um(run, (0.7, *LINES_HZ))[0] == pytest.approx(1e3 * abs(responses(0.7)[0]), rel=1e-6)


def test_phases_asked_for_in_the_error_are_found_there():
    from leadscrew.analysis.harmonics import least_squares

    asked = np.array(FITTED[1000])
    given = of_the_disturbance(asked, 0.775e-3)
    changes = {f"phase{n}": float(p) for n, p in zip((3, 5, 7, 9, 11), given, strict=True)}
    scenario = TABLE.scenario("spindle_1000", changes | {"runout_mv": 0.0, "tooth_mv": 0.0})
    run = lab().loop("paper.pid", scenario).run(20.0, record=("true_error",))
    late = run.time >= 10.0
    found = least_squares(run.time[late], run["true_error"][late], (0.7, *LINES_HZ)).phases
    relative = found[1:] - np.array([3, 5, 7, 9, 11]) * found[0]
    assert np.cos(relative - asked) == pytest.approx(np.ones(5), abs=1e-6)


def test_the_fitted_scenarios_have_the_fitted_phases_and_come_near_the_printed_column():
    off = []
    for rpm, phases in FITTED.items():
        p = TABLE.scenario(f"fitted_{rpm}").params
        given = np.array([p.phase3, p.phase5, p.phase7, p.phase9, p.phase11])
        assert np.cos(given - of_the_disturbance(np.array(phases), 0.775e-3)) == pytest.approx(np.ones(5), abs=1e-7)
        off += list(amplitudes_um(lab().run("corrected.npid_um", f"fitted_{rpm}")) - NPID_UM[rpm])
    assert np.sqrt(np.mean(np.square(off))) <= 0.12


def test_the_law_undoes_the_gain():
    errors = np.array([-40.0, -2.7, -0.3, 0.0, 1.1, 2.999, 8.0])
    scaled = np.array([1e3 * scaled_error(npid.params, 1e-3 * e) for e in errors])
    assert uncompressed(scaled) == pytest.approx(errors, abs=1e-5)


def test_large_errors_are_cut_by_the_largest_gain_and_small_ones_not_at_all():
    large = npid_rows(1000, np.zeros(5), 1e4)
    assert large / PID_UM[1000] == pytest.approx(np.full(5, 1.0 / np.cosh(1.5)), rel=0.01)
    assert misfit_um(3.0, {r: np.array(p) for r, p in FITTED.items()}) == pytest.approx(0.1192, abs=1e-4)


@pytest.mark.slow
def test_a_following_error_of_e_max_fits_best():
    expected = {1.4: 0.162, 2.5: 0.125, 3.0: 0.119, 4.0: 0.127}
    found = {motion: misfit_um(motion, refitted(motion, starts=3)) for motion in expected}
    assert list(found.values()) == pytest.approx(list(expected.values()), abs=0.0015)
    assert min(found, key=found.get) == 3.0


@pytest.mark.slow
def test_a_batch_of_trials_is_its_runs_one_by_one():
    found = tried(lab(), "paper.pid", draws=2, encoder=False)
    drawn = phases_of(2)[1]
    changes = {f"phase{n}": float(p) for n, p in zip((3, 5, 7, 9, 11), drawn, strict=True)}
    alone = lab().loop("paper.pid", TABLE.scenario("spindle_3000", changes)).run(20.0, record=("true_error",))
    assert found.at(3000)[1] == pytest.approx(amplitudes_um(alone), abs=1e-9)
    late = 1e3 * alone["true_error"][20000:]
    assert found.rms[5] == pytest.approx(np.sqrt(np.mean(late**2)), rel=1e-3) and found.speeds[5] == 3000


@pytest.mark.slow
def test_the_box_has_twelve_plants_and_the_printed_pid_holds_on_all():
    assert {len(v) for v in BOX.values()} == {12} and len(set(zip(*BOX.values(), strict=True))) == 12
    found = tried(lab(), "paper.pid", draws=1, box=True)
    assert np.isfinite(found.rows).all() and found.rows.max() == pytest.approx(1.67, abs=0.01)


def test_lines_above_half_of_the_sampling_frequency_are_looked_for_where_they_fold():
    loop = TABLE.loop("paper.pid", "spindle_1000", {"scenario.spindle_rpm": 24000.0, "scenario.teeth": 4})
    assert spindle_lines_hz(loop) == (400.0,)
    loop = TABLE.loop("paper.pid", "spindle_1000", {"scenario.spindle_rpm": 21000.0, "scenario.teeth": 4})
    assert spindle_lines_hz(loop) == (350.0, 600.0)
