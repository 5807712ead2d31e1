"""A dead zone in both readings, and a constant added to the output."""

import pytest

from leadscrew.actuators._dead_zone import dead_zone
from leadscrew.actuators._offset import offset
from leadscrew.controllers._vud import duty_pd
from leadscrew.kernel.loop import Loop
from leadscrew.plants._lathe_servo import lathe_servo
from leadscrew.references._step import step
from leadscrew.sensors._counts import grating_count
from leadscrew.util.errors import ValueRefused


def after(block, *outputs):
    return [block.step(block.params, x) for x in outputs]


def test_a_command_below_the_threshold_does_nothing_and_one_above_is_whole():
    assert after(dead_zone(threshold=0.05), 0.0499, -0.0499, 0.05, -0.3, 1.0) == [0.0, 0.0, 0.05, -0.3, 1.0]


def test_friction_takes_its_share_of_every_command():
    left = after(dead_zone(threshold=0.05, subtract=True), 0.04, -0.05, 0.06, -0.3, 1.0)
    assert left == pytest.approx([0.0, 0.0, 0.01, -0.25, 0.95], abs=1e-15)


def test_no_threshold_leaves_everything():
    for subtract in (False, True):
        assert after(dead_zone(threshold=0.0, subtract=subtract), 0.0, 1e-9, -0.7) == [0.0, 1e-9, -0.7]
    with pytest.raises(ValueRefused, match="threshold"):
        dead_zone(threshold=-0.1)


def test_an_offset_drifts_an_idle_axis_at_its_share_of_full_speed():
    """0.1/289 of full duty is 0.1 mm/s, towards negative x, whatever the lags."""
    idle = duty_pd(kp=0.0)
    loop = Loop(
        reference=step(target=0.0),
        controller=idle,
        plant=lathe_servo,
        sensor=grating_count,
        actuator=offset,
        metrics={},
    )
    x = loop.run(2.0, record=("actual.position",), engine="python")["actual.position"]
    assert x[-1] - x[-1001] == pytest.approx(-0.1, rel=1e-6)
