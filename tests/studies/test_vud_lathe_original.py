"""The original servo: what Table 1 says of plant and law, against hand sums, NumPy and the plain Python loop."""

import numpy as np
import pytest

from leadscrew.controllers._vud.power_law import power_law
from leadscrew.plants._lathe_servo import lathe_servo
from leadscrew.sensors._counts import encoder_count
from leadscrew.studies.vud_lathe import old_servo as original
from leadscrew.studies.vud_lathe.laws import bent_gain_fit, best_exponent, gain_fits, moves
from leadscrew.studies.vud_lathe.old_servo import EXPONENT, GAIN, SPEED
from tests.studies.lathe_lab import lab
from tests.studies.plain_loop import run_plain

MOVES = moves()
TIMES = np.arange(21) * 100


def misfits(speed, gain, exponent):
    """Misfit of a power law from each move in percent of its way, all in plain Python, no compiled loop."""
    parts = []
    for move in MOVES.values():
        run = run_plain(power_law(gain=gain, exponent=exponent), lathe_servo(full_duty_speed_mm_s=speed), encoder_count,
                        move.target_mm, 2001)  # fmt: skip
        e = (move.target_mm - run.signals["feedback"][TIMES]) / 190.0
        parts.append(100.0 * np.sqrt(np.mean((e - move.error) ** 2)) / np.ptp(move.error))
    return np.array(parts)


@pytest.mark.parametrize("law", ["power_289", "p_209"])
def test_the_misfit_is_that_of_a_plain_python_loop_and_no_neighbour_is_better(law):
    fit = original.fit_law(lab(), law)
    settings = {SPEED: 289.0, GAIN: 1.0, EXPONENT: 1.0, **original.LAWS[law].fixed, **fit.parameters}
    here = misfits(settings[SPEED], settings[GAIN], settings[EXPONENT])
    assert list(fit.nrmse_percent.values()) == pytest.approx(here, abs=1e-9)
    total = np.sqrt(np.mean(here**2))
    for key in fit.parameters:
        for factor in (0.97, 1.03):
            near = settings | {key: settings[key] * factor}
            assert np.sqrt(np.mean(misfits(near[SPEED], near[GAIN], near[EXPONENT]) ** 2)) > total


def test_the_study_s_stand_in_has_the_constants_of_the_fit():
    fit = original.fit_law(lab(), "power_289")
    assert power_law.params.gain == pytest.approx(fit.parameters[GAIN], abs=0.15 * fit.standard_error[GAIN])
    assert power_law.params.exponent == pytest.approx(fit.parameters[EXPONENT], abs=0.15 * fit.standard_error[EXPONENT])


@pytest.mark.slow
@pytest.mark.parametrize("law", list(original.LAWS))
def test_a_search_over_all_the_bounds_finds_nothing_better(law):
    """PID and PD may find a flatter corner of their valley, but no lower one."""
    everywhere = original.fit_law(lab(), law, "global")
    assert everywhere.total_percent == pytest.approx(original.fit_law(lab(), law).total_percent, abs=0.02)


def test_the_gain_of_one_move_is_that_of_numpy_on_its_simulated_travel():
    """The chain of lags by SciPy's lsim, duty linear between samples, and a straight line through the origin."""
    from scipy.signal import TransferFunction, lsim

    for name, move in MOVES.items():
        chain = TransferFunction([1.0], np.polymul(np.polymul([0.0008, 1.0], [0.0015, 1.0]), [0.017, 1.0, 0.0]))
        time = np.linspace(0.0, move.time_s[-1], 20_001)
        travel = lsim(chain, np.interp(time, move.time_s, move.duty), time)[1][::1000]
        way = 190.0 * (move.error[0] - move.error)
        by_hand = float(np.linalg.lstsq(travel[:, None], way, rcond=None)[0][0])
        assert gain_fits(MOVES)["linear"].gain_alone[name] == pytest.approx(by_hand, rel=1e-3)


def test_the_exponent_of_the_static_gain_is_a_minimum():
    best = best_exponent(MOVES)

    def total(exponent):
        return sum(m**2 for m in bent_gain_fit(MOVES, exponent).nrmse_percent.values())

    assert total(best) < min(total(best - 0.005), total(best + 0.005))


def test_the_linear_laws_creep_where_the_power_law_has_arrived():
    for way in original.TARGETS_MM:
        assert original.play(lab(), "power_289").within_s(way, 0.010) < 2.0
        for linear in ("p_209", "pid_209"):
            assert original.play(lab(), linear).within_s(way, 0.010) > 2.0
