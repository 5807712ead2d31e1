"""What a fit says of itself: errors that are those of its arrays, choices without the hold-out, worthless models, wrong
forms of friction, weights, starts and cuts.
"""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from leadscrew.identify.axis.fit import identify_axis
from leadscrew.identify.axis.result import AxisFit
from leadscrew.identify.axis.verdict import bins, force_left, sentence
from leadscrew.logs import axis_log
from leadscrew.report.identified_axis import sentences
from tests.identify.axis_oracle import Axis
from tests.identify.axis_runs import AXIS, DT, run, shove
from tests.identify.axis_truth import truths

COULOMB = "friction.forward.coulomb"
QUICK: dict[str, Any] = {"refine": "none", "model": "coulomb", "symmetric": True}


def shoved(force: np.ndarray | None = None, axis: Axis = AXIS, push: np.ndarray | float = 0.0) -> Any:
    log = run(axis, force)
    return axis_log(np.arange(len(log.force)) * DT, log.force + push, log.position, source="shoved")


def test_errors_that_are_stated_are_those_of_the_measured_and_simulated_positions():
    for j in identify_axis(shoved(), **QUICK).judged:
        error = j.simulated - j.measured
        assert j.rms == pytest.approx(np.sqrt(np.mean(error**2))) and j.worst == np.max(np.abs(error))
        assert j.nrmse_percent == pytest.approx(100.0 * j.rms / np.ptp(j.measured))
        left = j.force_left[np.isfinite(j.force_left)]
        assert j.rms_force == pytest.approx(np.sqrt(np.mean(left**2)))


def test_a_newton_that_the_model_lacks_is_a_newton_of_force_left():
    true = {"mass": 50.0, "offset": -2.0, "friction.forward.viscous": 120.0, "friction.backward.viscous": 120.0,
            COULOMB: 15.0, "friction.backward.coulomb": 15.0}  # fmt: skip
    left, force = force_left(run(), {**true, "offset": -1.0}, 41, 0.0)
    known = np.isfinite(left)
    assert known.mean() > 0.5 and np.median(left[known]) == pytest.approx(-1.0, abs=0.02)
    assert np.max(np.abs(force[known])) <= np.max(np.abs(run().force)) + 1e-9


@pytest.mark.slow
def test_nothing_of_a_fit_but_its_judgement_depends_on_the_hold_out():
    """The drive of the validation half is another one altogether: parameters, choice and intervals keep their bits."""
    push = np.zeros(8000)
    push[4900:] = 30.0 * np.sin(np.arange(3100) / 200.0)
    fits = [identify_axis(shoved(push=p), refine="none", holdout=0.4) for p in (0.0, push)]
    assert fits[0].parameters == fits[1].parameters and fits[0].compared == fits[1].compared
    errors = [fit.judged[1].rms_force for fit in fits]
    assert errors[1] > 10.0 * errors[0]


def test_a_log_that_begins_at_rest_with_full_drive_is_simulated_from_rest():
    force = shove()
    force[:60] = 150.0
    log = shoved(force)
    fit = identify_axis(log, **QUICK)
    assert log.position[20] - log.position[0] > 1e-4
    assert fit.judged[0].nrmse_percent < 1.0


def test_a_model_that_leaves_most_of_the_force_is_said_to_be_worthless_before_all_else():
    slow = np.repeat(np.random.default_rng(3).normal(0.0, 60.0, 80), 100)
    fit = identify_axis(shoved(push=slow), **QUICK)
    assert fit.judged[1].force_percent > 50.0
    assert "worthless" in sentences(fit)[0] and sentences(fit)[0] == fit.notes[0]
    assert identify_axis(shoved(), **QUICK).faults == []


def test_a_weight_does_not_hide_friction_by_direction():
    heavy = shoved(shove() + 490.0, AXIS._replace(offset=490.0))
    fit = identify_axis(heavy, refine="none", model="coulomb", symmetric=False)
    assert fit.parameters["offset"].how == "fixed" and fit.values["offset"] == pytest.approx(490.0, rel=1e-3)
    assert fit.values[COULOMB] == pytest.approx(15.0, rel=0.02)
    assert fit.values["friction.backward.coulomb"] == pytest.approx(15.0, rel=0.02)
    assert fit.values["mass"] == pytest.approx(50.0, rel=5e-3)


def test_the_cut_moves_to_where_the_training_part_goes_both_ways():
    force = shove()
    force[:4200] = np.where(force[:4200] > 0.0, 60.0, 20.0)
    fit = identify_axis(shoved(force), **QUICK)
    assert fit.judged[0].end_s > 4.2 and fit.parameters["friction.backward.coulomb"].how == "fitted"
    assert not any("one way" in note for note in fit.notes)


def lacks(seed: int, model: str) -> tuple[AxisFit, str]:
    log = truths((seed,))[0].log()
    fit = identify_axis(log, refine="none", model=model, holdout=0)
    from leadscrew.identify.axis.record import record_of

    found = bins(record_of(log), fit.values, 25, fit.values["delay_s"] / log.period)
    assert len(found) > 2
    return fit, sentence(found, "m", "N")


@pytest.mark.slow
def test_a_form_of_friction_that_does_not_fit_is_said_and_one_that_does_is_not():
    """Axis 67 rises from 83 to 103 N below 10 mm/s; axis 72 is Coulomb's."""
    fit, said = lacks(67, "coulomb")
    assert "forwards from 0.002" in said and "more than the model" in said
    assert any(note.startswith("The form of friction does not fit: ") for note in fit.notes)
    assert lacks(67, "auto")[0].model == "stribeck" and lacks(67, "auto")[1] == "" and lacks(72, "auto")[1] == ""


@pytest.mark.slow
def test_a_delay_that_least_squares_cannot_identify_is_identified_by_simulation_and_so_is_the_mass():
    """A small axis in a stiff loop that feeds noise of 10 um back: least squares say -6 to 25 ms of the delay 0."""
    from tests.identify.excite_machine import run as excited
    from tests.identify.test_excite_round_trip import SMALL, proposed, recorded

    guess, noise, limits, true = SMALL
    move = proposed(guess, ["mass", "friction", "offset", "delay"], noise, limits)
    log = recorded(move, Path(tempfile.mkdtemp()), *excited(move.samples, **true, noise=1e-5, seed=4))
    rough = identify_axis(log, refine="none", model="coulomb", symmetric=True)
    assert not rough.parameters["delay_s"].identifiable and not rough.parameters["mass"].identifiable
    ends = rough.parameters["delay_s"].note.split("from the log, ")[1].split(" s")[0]
    low, high = (float(x) for x in ends.split(" to "))
    assert low < 0.0 < high
    fit = identify_axis(log, model="coulomb", symmetric=True)
    assert fit.parameters["delay_s"].identifiable and 0.0 <= fit.parameters["delay_s"].high < 1e-4
    mass = fit.parameters["mass"]
    assert mass.identifiable and mass.low <= 2.0 <= mass.high and mass.percent < 0.2


@pytest.mark.slow
def test_a_play_at_the_table_is_refined_with_the_other_parameters():
    from tests.identify.test_axis_backlash import log_of

    fit = identify_axis(replace(log_of(20e-6, "table"), command=None), model="coulomb", symmetric=True, holdout=0)
    play = fit.parameters["backlash"]
    assert play.how == "fitted" and play.identifiable and play.low <= 20e-6 <= play.high
    assert identify_axis(log_of(0.0, "table"), model="coulomb", symmetric=True).values["backlash"] == 0.0
