"""A loop whose blocks do not fit by unit or drive warns; one whose blocks fit, or do not say, is quiet."""

import warnings

import pytest

from leadscrew import Loop, controller
from leadscrew.actuators import saturation, torque_drive
from leadscrew.controllers import npid, torque_pid
from leadscrew.kernel.units import UnitWarning
from leadscrew.plants import mass_lugre, xy_table
from leadscrew.references import s_curve, step
from leadscrew.sensors import ruler


@controller()
def plain(command, feedback):
    return command - feedback


@pytest.mark.parametrize(
    ("blocks", "text"),
    [
        ({"controller": torque_pid, "plant": xy_table}, "torque_pid commands a torque, and xy_table takes a voltage"),
        (
            {"controller": torque_pid, "plant": xy_table, "actuator": saturation},
            "torque_pid commands a torque, and xy_table takes a voltage",
        ),
        ({"controller": npid, "plant": mass_lugre}, "npid commands a voltage, and mass_lugre takes a force"),
        (
            {"reference": s_curve(), "controller": plain, "plant": mass_lugre},
            "the command of s_curve is in mm, the feedback of mass_lugre in m",
        ),
    ],
)
def test_blocks_that_do_not_fit_are_named(blocks, text):
    with pytest.warns(UnitWarning) as caught:
        Loop(**{"reference": step()} | blocks, period=1e-3)
    assert text in str(caught[0].message) and len(caught) == 1


def test_blocks_that_fit_or_convert_or_do_not_say_are_quiet():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Loop(reference=s_curve(), controller=npid, plant=xy_table, sensor=ruler, period=1e-3)
        Loop(reference=step(), controller=plain, plant=mass_lugre, period=1e-3)
        Loop(reference=step(), controller=torque_pid, actuator=torque_drive, plant=xy_table, period=1e-3)
