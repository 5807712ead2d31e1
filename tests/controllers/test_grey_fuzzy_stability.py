"""The linear force loop of the study against the lathe itself, against eigenvalues, and other margins."""

import numpy as np
import pytest

from leadscrew.studies.grey_turning.linear_force_loop import (
    boundary,
    first_part,
    force_loop,
    force_margins,
    force_plant,
)
from leadscrew.studies.grey_turning.study import STUDY
from leadscrew.studies.grey_turning.tunings import FACTORS
from leadscrew.studies.lab import Lab

S9_HALF = FACTORS["s9_half"]


def sizes(name, machine, gains):
    """Largest departure from 150 N from 10 and from 20 s on, without noise and runout; a row a gain."""
    loop = Lab(STUDY).loop(name, "noise_free", machine=machine, metrics={})
    run = loop.batch(21.0, {"controller.output_scale": np.asarray(gains)}, record=("actual.force",))
    off = np.abs(np.asarray(run["actual.force"]) - 150.0)
    return np.stack([off[:, 500:550].max(axis=1), off[:, 1000:1050].max(axis=1)], axis=1)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "name", "machine"),
    [
        ("tfc", "tfc_s9_half", "plant_f"),
        pytest.param("gpfc_b", "gpfc_b_s9_half", "plant_f", marks=pytest.mark.slow),
        pytest.param("tfc", "tfc_s6n", "plant_n", marks=pytest.mark.slow),
    ],
)
def test_the_lathe_oscillates_where_the_gain_margin_ends_and_calms_down_as_its_poles_say(law, name, machine):
    f = FACTORS[name.split("_", 2 if law == "gpfc_b" else 1)[-1]]
    margin = force_margins(machine, law, f.kp, f.ki).gain
    (first, last), (grown, still) = sizes(f"corrected.{name}", machine, f.output * margin * np.array([0.94, 1.04]))
    pole = np.abs(force_loop(machine, law, 0.94 * margin * f.kp, 0.94 * margin * f.ki).closed_poles()).max()
    assert last / first == pytest.approx(pole**500, rel=0.1)
    assert still > 10.0 and still == pytest.approx(grown, rel=0.1)


def test_the_plant_has_the_slope_of_the_power_law():
    plant = force_plant("plant_f")
    assert plant.slope == pytest.approx(0.77 * 150.0 / 35.50, rel=1e-3)  # P F / v, 35.50 mm/min for 150 N
    assert plant.gain == pytest.approx(150.0 * plant.slope, rel=1e-9)  # 150 mm/min a volt
    assert force_plant("plant_f", depth=0.4).slope == pytest.approx(0.99, abs=0.005)


@pytest.mark.parametrize(
    ("machine", "law"),
    [("plant_f", "gpfc_a"), pytest.param("plant_n", "two_point", marks=pytest.mark.slow)]
    + [pytest.param(m, law, marks=pytest.mark.slow) for m in ("plant_f", "plant_n") for law in ("tfc", "gpfc_b")],
)
def test_a_pole_crosses_the_unit_circle_where_the_boundary_says(machine, law):
    kp, ki = first_part(machine, law)
    for k in (len(kp) // 3, 3 * len(kp) // 4):
        for factor, inside in ((0.99, True), (1.01, False)):
            loop = force_loop(machine, law, factor * kp[k], factor * ki[k])
            assert (np.abs(loop.closed_poles()).max() < 1.0) == inside
    assert len(boundary(machine, law)[0]) > len(kp)


def test_the_margins_are_those_of_the_response_that_the_stability_tools_compute():
    from scipy.optimize import brentq

    found = force_margins("plant_f", "tfc", S9_HALF.kp, S9_HALF.ki)
    loop = force_loop("plant_f", "tfc", S9_HALF.kp, S9_HALF.ki)
    at_gain = brentq(lambda w: abs(loop.response(w).item()) - 1.0, 5.0, 12.0, xtol=1e-6)
    at_phase = brentq(lambda w: loop.response(w).item().imag, 15.0, 20.0, xtol=1e-6)
    assert found.phase_deg == pytest.approx(180.0 + np.degrees(np.angle(loop.response(at_gain))), abs=0.02)
    assert found.gain == pytest.approx(1.0 / abs(loop.response(at_phase)), rel=1e-4)
