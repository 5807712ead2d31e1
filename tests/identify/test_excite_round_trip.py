"""From a proposal to a log to a fit: what was missing is told, as well as was predicted."""

import math

import numpy as np
import pytest

from leadscrew.identify.axis.fit import identify_axis
from leadscrew.identify.excite import Limits, propose
from leadscrew.identify.excite.belief import Belief, keys_of, values_of
from leadscrew.identify.excite.files import Machine, header
from leadscrew.logs import read_axis_log
from tests.identify.excite_machine import run


def proposed(guess, tell, noise, limits, symmetric=True):
    return propose(limits, Belief(values_of(guess), noise, 1e-3, symmetric, wanted=keys_of(tell)))


def recorded(proposal, folder, drive, position):
    """The log as record.sh and halsampler write it."""
    rows = np.column_stack([
        np.arange(len(position)), 1e3 * proposal.samples.position, 1e3 * position, drive,
    ])  # fmt: skip
    with (folder / "log.txt").open("w") as file:
        file.write(header(proposal, Machine(drive_unit="N")) + "\n")
        np.savetxt(file, rows, fmt="%d %.7f %.7f %.7f")
    return read_axis_log(folder / "log.txt")


def ratios(proposal, fit):
    """Interval found over interval predicted."""
    halves = {p.key: 0.5 * (fit.parameters[p.key].high - fit.parameters[p.key].low) for p in proposal.predicted}
    return {p.key: halves[p.key] / p.half for p in proposal.predicted}


LARGE = ({"mass": 80.0, "coulomb": 25.0, "viscous": 150.0}, 1e-5, Limits(0.0, 0.3, 0.2, 2.0, 20.0, 60.0),
         {"mass": 95.0, "coulomb": (20.0, 20.0), "viscous": (200.0, 200.0), "offset": -3.0})  # fmt: skip
SMALL = ({"mass": 3.0, "coulomb": 8.0, "viscous": 20.0, "offset": 0.4}, 1e-6, Limits(-0.02, 0.02, 0.1, 5.0, 0.0, 30.0),
         {"mass": 2.0, "coulomb": (6.0, 6.0), "viscous": (30.0, 30.0), "offset": 0.5})  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("axis", [LARGE, SMALL], ids=["large", "small"])
def test_the_log_of_a_test_move_tells_what_was_missing_as_well_as_predicted(axis, tmp_path):
    guess, noise, limits, true = axis
    proposal = proposed(guess, ["mass", "friction", "offset", "delay"], noise, limits)
    assert {p.verdict for p in proposal.predicted} == {"identifiable"}
    log = recorded(proposal, tmp_path, *run(proposal.samples, **true, noise=noise))
    assert [f for f in log.findings if f.severity != "note"] == []
    fit = identify_axis(log)
    found = ratios(proposal, fit)
    # Each interval of a fit is itself estimated from a few dozen pieces of evidence: a factor of 2 for all together.
    together = math.exp(np.mean([math.log(r) for r in found.values()]))
    assert 0.5 <= together <= 2.0 and all(0.4 <= r <= 2.5 for k, r in found.items() if k != "delay_s"), found
    expected = {
        "mass": true["mass"], "friction.forward.coulomb": true["coulomb"][0],
        "friction.forward.viscous": true["viscous"][0], "offset": true["offset"],
    }  # fmt: skip
    for key, value in expected.items():
        parameter = fit.parameters[key]
        assert parameter.identifiable and parameter.how == "fitted"
        assert parameter.value == pytest.approx(value, rel=0.01, abs=0.02)


@pytest.mark.slow
def test_a_test_for_the_stribeck_curve_makes_the_fit_find_it(tmp_path):
    guess = {"mass": 80.0, "coulomb": 25.0, "viscous": 150.0, "static": 30.0, "stribeck_speed": 0.008}
    limits = Limits(0.0, 0.3, 0.2, 2.0, 20.0, 60.0)
    proposal = proposed(guess, ["mass", "friction", "stribeck"], 1e-6, limits)
    true = {"mass": 95.0, "coulomb": (20.0, 20.0), "viscous": (200.0, 200.0), "static": (28.0, 28.0)}
    drive, position = run(proposal.samples, **true, stribeck_speed=0.005, noise=1e-6, substeps=50)
    fit = identify_axis(recorded(proposal, tmp_path, drive, position))
    assert fit.model == "stribeck" and fit.missing == ()
    assert fit.values["friction.forward.static"] == pytest.approx(28.0, rel=0.01)
    assert fit.values["friction.forward.stribeck_speed"] == pytest.approx(0.005, rel=0.01)
    found = ratios(proposal, fit)
    together = math.exp(np.mean([math.log(r) for r in found.values()]))
    assert 0.5 <= together <= 2.0, found
