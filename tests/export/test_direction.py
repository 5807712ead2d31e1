"""Every controller in place of ``pid`` on a plant of stock HAL: the first move is towards the command."""

import numpy as np
import pytest

from leadscrew.export import hal_check, hal_run
from tests.budget import WHOLE
from tests.export.hal_bench import needed
from tests.export.table import ROWS, folder_of, loop_of

PERIODS = 400
BACKWARDS = [r for r in ROWS if ROWS[r].backwards and not r.startswith("60 s")]
ONE_A_DRIVE = ["vud_beta_e", "npid", "axis_cascade", "smc", "tangent_dob"]
STOCK = ["setp pid.0.Pgain 0.25", "setp pid.0.maxoutput 0.3"]


def moved(place, load, instance, function, setup, thread):
    """Output of a controller and position of an integrating plant, period by period."""
    lines = [
        f"loadrt threads name1=servo period1={thread}",
        f"loadrt sampler depth={PERIODS + 10} cfg=ff",
        load,
        "loadrt integ names=plant",
        *(f"addf {f} servo" for f in (function, "plant", "sampler.0")),
        f"net drive {instance}.output => plant.in sampler.0.pin.0",
        f"net position plant.out => {instance}.feedback sampler.0.pin.1",
        f"setp {instance}.enable 1",
        *setup,
        "start",
        *hal_check.reading(place, PERIODS, "ff"),
    ]
    hal_check.ran(place, lines, thread, PERIODS, 300)
    return hal_check.taken(place, 2)


def first(values):
    """The first that is more than what rounding leaves: a controller that starts without a bump begins with 1e-15."""
    return values[np.flatnonzero(np.abs(values) > 1e-9 * np.abs(values).max())[0]]


@pytest.mark.slow
def test_every_kind_of_drive_has_a_row():
    """The sign at a drive is that of its kind: duty, voltage, torque, position, or the machine's own unit."""
    kinds = [loop_of(row).blocks["controller"].drive for row in ONE_A_DRIVE]
    assert sorted(kinds) == sorted({loop_of(row).blocks["controller"].drive for row in BACKWARDS})


@pytest.mark.slow
@pytest.mark.parametrize("row", BACKWARDS if WHOLE else ONE_A_DRIVE)
def test_the_first_move_is_that_of_stock_pid(row, tmp_path):
    needed()
    folder = folder_of(row, "hal", tmp_path)
    thread = round(loop_of(row).period * 1e9)
    unlimited = ["setp ours.0.max-following-error 0", "setp ours.0.max-wrong-way 0"]
    with hal_run.workplace() as place:
        hal_run.install(place, folder, "ours")
        for command in (1.0, -1.0):
            ours = moved(
                place, "loadrt ours", "ours.0", "ours.0", [*unlimited, f"setp ours.0.command {command}"], thread
            )
            pid = [*STOCK, f"setp pid.0.command {command}"]
            stock = moved(place, "loadrt pid num_chan=1", "pid.0", "pid.0.do-pid-calcs", pid, thread)
            for column in (0, 1):
                assert np.sign(first(ours[:, column])) == np.sign(first(stock[:, column])) == np.sign(command)
