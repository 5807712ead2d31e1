"""Pre-sliding of an axis in m and N: found where the log has it, and a reason where it has not."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest

from leadscrew import Loop
from leadscrew.controllers._pd_dob import pd_dob
from leadscrew.identify.axis.static_friction import presliding
from leadscrew.logs.arrays import axis_log
from leadscrew.plants._ballscrew_stage import INERTIA, ballscrew_stage
from leadscrew.references._friction_test import friction_test, friction_test_duration
from leadscrew.sensors._counts import ruler
from tests.identify.test_axis_simulation import PUBLISHED, emps

PER_RAD = 1.5923e-3
"""m of travel per rad of the stage of Shams and Safdari (2010)."""


@pytest.mark.slow
def test_emps_turns_too_fast_for_bristles_and_says_so() -> None:
    found = presliding(emps(), PUBLISHED)
    assert found.why_not and found.parameters == {}
    assert "does not determine the stiffness and the damping of the bristles" in found.why_not


@pytest.mark.slow
@pytest.mark.parametrize("unit", ["rad", "m"])
def test_a_ball_screw_stage_gives_its_bristles_in_rad_and_in_metres(unit: Literal["rad", "m"]) -> None:
    """sigma_0 = 1e5 N m/rad, sigma_1 = sqrt(1e5) N m s/rad: stiffness within 2 %, and the same axis in m and N."""
    bare = pd_dob(kp=300.0, kd=0.5, kp_slow=0.0, kd_slow=0.0, observer_rate=0.0, friction=False, travel_per_rad=1.5923)
    loop = Loop(
        reference=friction_test(), controller=bare, plant=ballscrew_stage(travel_per_rad=1.5923),
        sensor=ruler(resolution_mm=1e-5), period=2.5e-4, method="rodas", rtol=1e-6, atol=1e-12, metrics={},
    )  # fmt: skip
    run = loop.run(friction_test_duration(), record=("output", "feedback"))
    x, u = 1e-3 * np.asarray(run["feedback"]), np.asarray(run["output"])
    turn = PER_RAD if unit == "m" else 1.0
    log = axis_log(run.time, u / turn, x / PER_RAD * turn, position_unit=unit, drive_unit="N" if unit == "m" else "N m")
    found = presliding(log, {})
    assert not found.why_not and found.consistent
    assert found.parameters["friction.stiffness"].value * turn**2 == pytest.approx(1e5, rel=0.02)
    assert found.parameters["friction.damping"].value * turn**2 == pytest.approx(np.sqrt(1e5), rel=0.02)
    assert found.parameters["friction.forward.static"].value * turn == pytest.approx(9.36, rel=0.02)
    assert found.parameters["friction.forward.stribeck_speed"].value / turn == pytest.approx(1e-3, rel=0.02)
    assert found.parameters["mass"].value * turn**2 == pytest.approx(INERTIA, rel=0.02)
    assert all(p.identifiable for p in found.parameters.values())
