"""Table II from simulation: the calibration, the compression law, trials over phases and plants."""

import numpy as np
import pytest

from leadscrew.catalogue import study
from leadscrew.controllers.npid import npid, scaled_error
from leadscrew.controllers.wrapping import takes_motion
from leadscrew.kernel.errors import LeadscrewError
from leadscrew.studies.npid_xytable.calibration import LINES_HZ, gain_um_per_mv, responses
from leadscrew.studies.npid_xytable.columns import NPID_UM, PID_UM, PRINTED_PERCENT
from leadscrew.studies.npid_xytable.compression import (
    FITTED,
    misfit_um,
    npid_rows,
    of_the_disturbance,
    refitted,
    uncompressed,
)
from leadscrew.studies.npid_xytable.runs import Loops, amplitudes_um, spindle_lines_hz, tail_um
from leadscrew.studies.npid_xytable.trials import BOX, phases_of, trial

TABLE = study("npid_xytable")


def test_the_columns_are_those_of_the_paper():
    assert PID_UM[1000] == (0.7865, 0.4205, 0.7650, 0.7670, 0.5239) and NPID_UM[3000][-1] == 0.2048
    assert PRINTED_PERCENT[2000] == (58, 18, 23, 43, 60)


def test_a_millivolt_moves_the_axis_by_three_quarters_of_a_micrometre():
    digest = (0.75471, 0.75208, 0.74818, 0.74309, 0.73687)
    assert [gain_um_per_mv(f) for f in LINES_HZ] == pytest.approx(digest, abs=1e-5)


def test_the_closed_form_is_what_a_simulation_does():
    loops = Loops()
    run = loops.run("paper.pid", "spindle_2000")
    assert amplitudes_um(run) == pytest.approx(PID_UM[2000], abs=1e-4)
    assert amplitudes_um(run, (0.7, *LINES_HZ))[0] == pytest.approx(1e3 * abs(responses(0.7)[0]), rel=1e-6)


def test_phases_asked_for_in_the_error_are_found_there():
    from leadscrew.analysis.harmonics import least_squares

    asked = np.array(FITTED[1000])
    given = of_the_disturbance(asked, 0.775e-3)
    changes = {f"phase{n}": float(p) for n, p in zip((3, 5, 7, 9, 11), given, strict=True)}
    scenario = TABLE.scenario("spindle_1000", changes | {"runout_mv": 0.0, "tooth_mv": 0.0})
    run = Loops().run("paper.pid", scenario)
    late = run.time >= 10.0
    found = least_squares(run.time[late], run["true_error"][late], (0.7, *LINES_HZ)).phases
    relative = found[1:] - np.array([3, 5, 7, 9, 11]) * found[0]
    assert np.cos(relative - asked) == pytest.approx(np.ones(5), abs=1e-6)


def test_the_fitted_scenarios_have_the_fitted_phases_and_come_near_the_printed_column():
    loops, off = Loops(), []
    for rpm, phases in FITTED.items():
        p = TABLE.scenario(f"fitted_{rpm}").params
        given = np.array([p.phase3, p.phase5, p.phase7, p.phase9, p.phase11])
        assert np.cos(given - of_the_disturbance(np.array(phases), 0.775e-3)) == pytest.approx(np.ones(5), abs=1e-7)
        off += list(amplitudes_um(loops.run("corrected.npid_um", f"fitted_{rpm}")) - NPID_UM[rpm])
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
    digest = {1.4: 0.162, 2.0: 0.138, 2.5: 0.125, 3.0: 0.119, 3.5: 0.120, 4.0: 0.127, 5.0: 0.142, 7.1: 0.169}
    found = {motion: misfit_um(motion, refitted(motion, starts=3)) for motion in digest}
    assert list(found.values()) == pytest.approx(list(digest.values()), abs=0.0015)
    assert min(found, key=found.get) == 3.0


@pytest.mark.slow
def test_a_batch_of_trials_is_its_runs_one_by_one():
    loops = Loops()
    found = trial(loops, "paper.pid", draws=2, encoder_um=0.0, noise_um=0.0)
    drawn = phases_of(2)[1]
    changes = {f"phase{n}": float(p) for n, p in zip((3, 5, 7, 9, 11), drawn, strict=True)}
    alone = loops.run("paper.pid", TABLE.scenario("spindle_3000", changes))
    assert found.at(3000)[1] == pytest.approx(amplitudes_um(alone), abs=1e-9)
    assert found.rms[5] == pytest.approx(tail_um(alone)[1], rel=1e-3) and found.speeds[5] == 3000


@pytest.mark.slow
def test_the_box_has_twelve_plants_and_the_printed_pid_holds_on_all():
    assert {len(v) for v in BOX.values()} == {12} and len(set(zip(*BOX.values(), strict=True))) == 12
    found = trial(Loops(), "paper.pid", draws=1, box=BOX)
    assert np.isfinite(found.rows).all() and found.rows.max() == pytest.approx(1.67, abs=0.01)


def test_lines_above_half_of_the_sampling_frequency_are_looked_for_where_they_fold():
    loop = TABLE.loop("paper.pid", "spindle_1000", {"scenario.spindle_rpm": 24000.0, "scenario.teeth": 4})
    assert spindle_lines_hz(loop) == (400.0,)
    loop = TABLE.loop("paper.pid", "spindle_1000", {"scenario.spindle_rpm": 21000.0, "scenario.teeth": 4})
    assert spindle_lines_hz(loop) == (350.0, 600.0)


@pytest.mark.slow
def test_a_controller_on_motion_gets_a_motion():
    for name, block in TABLE.controllers.items():
        loop = TABLE.loop(name, "spindle_1000")
        assert takes_motion(block) == hasattr(loop.signals["command"], "velocity"), name


def test_values_out_of_range_are_refused_with_their_range():
    with pytest.raises(LeadscrewError, match=r"amplitude_mm = -1.*\[0, 500\]"):
        TABLE.scenario("spindle_1000", {"amplitude_mm": -1.0})
    with pytest.raises(LeadscrewError, match=r"column = 1500.*Table II has \[1000, 2000, 3000\]"):
        TABLE.loop("paper.pid", "spindle_1000", {"scenario.column": 1500})
