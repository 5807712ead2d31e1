"""The test move on LinuxCNC itself: its interpreter reads the program; its simulator runs and records it."""

import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from leadscrew.export import hal_run
from leadscrew.identify.excite import Limits, propose, write
from leadscrew.identify.excite.belief import Belief, keys_of, values_of
from leadscrew.logs import read_axis_log, read_table
from tests.export.linuxcnc_machine import seen_by
from tests.tools import missing

MACHINE = Path(__file__).with_name("excite_sim")
SCREEN = Path(__file__).parents[1] / "export" / "linuxcnc_sim" / "screen.py"


@pytest.fixture(scope="module")
def proposal():
    values = values_of({"mass": 95.0, "coulomb": 20.0, "viscous": 200.0})
    belief = Belief(values, 1e-6, 1e-3, wanted=keys_of(["mass", "friction"]))
    return propose(Limits(0.0, 0.3, 0.2, 2.0, 0.0, 30.0), belief)


def test_linuxcnc_s_interpreter_stops_at_every_end_of_the_move_at_the_feeds_of_the_proposal(proposal, tmp_path):
    if shutil.which("rs274") is None:
        missing("linuxcnc", "rs274 is not installed: install linuxcnc-uspace")
    write(proposal, tmp_path / "test")
    (tmp_path / "a.tbl").write_text("")
    done = subprocess.run(
        ["rs274", "-g", "-t", "a.tbl", "-v", "a.var", "test/move.ngc"],
        cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False,
        env={**os.environ, "HOME": str(tmp_path)},  # its tool table is mapped from there: two at a time end in SIGBUS
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-500:] + done.stderr[-500:]
    lines = [line.split(maxsplit=2)[-1] for line in done.stdout.splitlines()]
    ends = [float(x.split("(")[1].split(",")[0]) for x in lines if x.startswith("STRAIGHT_FEED")]
    feeds = [float(x.split("(")[1].rstrip(")")) for x in lines if x.startswith("SET_FEED_RATE")]
    assert ends == pytest.approx([150.0, *(1e3 * s.end for s in proposal.move.strokes)], abs=1e-4)
    assert max(feeds) == pytest.approx(60e3 * 0.98 * 0.2) and 60e3 * 0.1 * 0.2 in feeds
    assert any(x.startswith("SET_MOTION_CONTROL_MODE") and "EXACT_STOP" in x for x in lines)
    assert not any(x.startswith("STRAIGHT_TRAVERSE") for x in lines)
    assert sum(x.startswith("DWELL") for x in lines) == len(proposal.move.strokes) + 1


@pytest.mark.slow
def test_linuxcnc_runs_the_move_inside_its_limits_and_its_recorder_s_log_is_read_as_it_is(proposal):
    why = hal_run.lacking()
    if why:
        missing("linuxcnc", why)
    with hal_run.workplace() as place:
        machine = place / "machine"
        shutil.copytree(MACHINE, machine, ignore=shutil.ignore_patterns("__pycache__"))
        shutil.copyfile(SCREEN, machine / "screen.py")
        write(proposal, place / "test")
        for name in ("move.ngc", "record.hal", "record.sh"):
            shutil.copy(place / "test" / name, machine / name)
        found = seen_by(machine, place, 150.0)
        table, log = read_table(machine / "log.txt"), read_axis_log(machine / "log.txt")
    assert found["homed"] and found["errors"] == []
    assert list(table.columns) == ["time [0.001 s]", "command [mm]", "position [mm]", "drive [V]"]
    assert log.period == pytest.approx(0.001) and log.unit == ("m", "V") and table.lost == ()
    position = log.command
    assert position.min() > -1e-9 and position.max() < 0.3
    speed, limit = np.diff(position) / 1e-3, proposal.limits
    assert np.abs(speed).max() <= 0.981 * limit.speed
    assert np.abs(np.diff(speed) / 1e-3).max() <= 0.99 * limit.acceleration
    # From the first stroke on the recorded command is the reference, but for how LinuxCNC rounds times to periods.
    wanted = proposal.samples.position
    starts = np.flatnonzero(np.abs(position - wanted[0]) < 1e-7)
    first = starts[np.flatnonzero(np.diff(starts) > 1)[0]]
    begun = int(np.flatnonzero(np.abs(wanted - wanted[0]) > 1e-7)[0])
    seen = position[first + 1 :]
    reached = [seen[np.abs(seen - s.end).argmin()] - s.end for s in proposal.move.strokes]
    assert np.abs(reached).max() < 1e-6
    half_a_second = slice(0, 400)
    assert np.abs(seen[half_a_second] - wanted[begun:][half_a_second]).max() < 0.5e-3
    # Strokes take their time in periods of the servo thread; rests are ended by the task, on a busy machine later.
    moves = np.flatnonzero(np.diff(seen) != 0.0)
    wanted_moves = np.flatnonzero(np.abs(np.diff(wanted[begun:])) > 1e-9)
    step = proposal.samples.time[1] - proposal.samples.time[0]
    assert len(moves) * 1e-3 == pytest.approx(len(wanted_moves) * step, rel=0.005)
    assert (moves[-1] - len(moves)) * 1e-3 > 0.99 * (wanted_moves[-1] - len(wanted_moves)) * step
