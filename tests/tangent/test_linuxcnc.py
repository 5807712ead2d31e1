"""LinuxCNC itself: its interpreter reads every program, and its simulator cuts one, with the axis on the tangent."""

import math
import os
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from leadscrew.export import hal_run
from leadscrew.paths import shapes
from leadscrew.paths.path import polyline
from leadscrew.tangent.emit import program
from leadscrew.tangent.interpreter import read_moves
from leadscrew.tangent.settings import MM_PER_INCH, Settings
from leadscrew.tangent.stroke import Stroke, Table, strokes_of
from tests.export.linuxcnc_machine import seen_by
from tests.tools import missing

SQUARE = np.array([[0, 0], [20, 0], [20, 20], [0, 20]])
DRAWINGS = {
    "wave": [shapes.wave()],
    "flower": [shapes.flower()],
    "rounded rectangle": [shapes.rounded_rectangle()],
    "square": [polyline(SQUARE, closed=True)],
}
VARIANTS = {
    "C": Settings(pricks="-5,2.5 80,-3"),
    "A, clockwise": Settings(axis="A", clockwise=True, zero=90.0, start_angle=1000.0),
    "inch, inverse time": Settings(inch=True, inverse_time=True),
    "slow blade, overcut": Settings(swivel=60.0, overcut=2.0),
}
MOVE = re.compile(r"(STRAIGHT_FEED|STRAIGHT_TRAVERSE|ARC_FEED)\(([^)]*)\)")
KINDS = {0: "STRAIGHT_TRAVERSE", 1: "STRAIGHT_FEED", 2: "ARC_FEED", 3: "ARC_FEED"}
MACHINE = Path(__file__).with_name("linuxcnc_sim")
SCREEN = Path(__file__).parents[1] / "export" / "linuxcnc_sim" / "screen.py"


def canon(text, folder):
    """What LinuxCNC's interpreter makes of a program: kind, X, Y, Z, A, C of the end of each move."""
    if shutil.which("rs274") is None:
        missing("linuxcnc", "rs274 is not installed: install linuxcnc-uspace")
    (folder / "a.ngc").write_text(text, encoding="utf-8")
    (folder / "a.tbl").write_text("", encoding="utf-8")
    done = subprocess.run(
        ["rs274", "-g", "-t", "a.tbl", "-v", "a.var", "a.ngc"],
        cwd=folder, capture_output=True, text=True, timeout=60, check=False,
        env={**os.environ, "HOME": str(folder)},  # its tool table is mapped from there: two at a time end in SIGBUS
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-500:] + done.stderr[-500:]
    rows = []
    for kind, values in MOVE.findall(done.stdout):
        v = [float(x) for x in values.split(",")]
        # ARC_FEED: end, centre, turns, Z, A, B, C.
        rows.append((kind, v[0], v[1], *((v[5], v[6], v[8]) if kind == "ARC_FEED" else (v[2], v[3], v[5]))))
    return rows


def offset(stroke):
    s = stroke.grid(0.5)
    return Stroke(stroke.path, stroke.length, stroke.bends, table=Table(s, 5.0 * np.sin(s / 9.0)))


@pytest.mark.parametrize("settings", VARIANTS.values(), ids=VARIANTS)
@pytest.mark.parametrize("drawing", [pytest.param(d, marks=() if d[0] in "rs" else pytest.mark.slow) for d in DRAWINGS])
@pytest.mark.parametrize("compensated", [False, True])
def test_linuxcnc_s_interpreter_reads_every_program_to_the_same_ends_and_angles(
    drawing, settings, compensated, tmp_path
):
    strokes = strokes_of(DRAWINGS[drawing], settings)
    text = program([offset(s) for s in strokes] if compensated else strokes, settings)
    rows, steps = canon(text, tmp_path), read_moves(text, "ours").steps
    scale = MM_PER_INCH if settings.inch else 1.0
    assert [KINDS[s.code] for s in steps] == [r[0] for r in rows]
    seen = np.array([[r[1] * scale, r[2] * scale, r[3] * scale, r[4 if settings.axis == "A" else 5]] for r in rows])
    ours = np.array([[*s.end, s.words[1]] for s in steps])
    assert np.abs(seen - ours).max() <= 1.01e-4 * scale  # what rs274 prints has four decimals
    assert not np.any([r[5 if settings.axis == "A" else 4] for r in rows])


@pytest.mark.slow
def test_the_whole_of_linuxcnc_cuts_with_the_axis_on_the_tangent_at_the_programmed_feed(tmp_path):
    """F is the speed along the line, turning axis or not; what short moves cost is on the page."""
    why = hal_run.lacking()
    if why:
        missing("linuxcnc", why)
    lines = {"rectangle": shapes.rounded_rectangle(), "flower": shapes.flower()}
    with hal_run.workplace() as place:
        machine = place / "machine"
        shutil.copytree(MACHINE, machine, ignore=shutil.ignore_patterns("__pycache__"))
        shutil.copyfile(SCREEN, machine / "screen.py")
        for name, path in lines.items():
            (machine / f"{name}.ngc").write_text(program(strokes_of([path], Settings()), Settings()), encoding="utf-8")
        found = seen_by(machine, place, 150.0)
    assert found["homed"] and found["errors"] == []
    for name, path in lines.items():
        time, x, y, z, c, speed = np.array(found["runs"][name]).T
        cutting = z < -0.999
        fine = np.linspace(0.0, path.length, 40000)
        at = path.at(fine)
        away = np.array([np.hypot(at.x - a, at.y - b).argmin() for a, b in zip(x[cutting], y[cutting], strict=True)])
        distance = np.hypot(at.x[away] - x[cutting], at.y[away] - y[cutting])
        assert distance.max() < 0.03
        off = (c[cutting] - at.heading[away] + 180.0) % 360.0 - 180.0
        assert math.sqrt(np.mean(off**2)) < 0.3 and np.abs(off).max() < 4.0
        assert np.median(speed[cutting]) == pytest.approx(50.0, rel=0.15)
        # a busy machine looks for the first and the last time when some of the line is behind it, or ahead
        begin, end, half = fine[away[0]], fine[away[-1]], 0.5 * path.length
        seen = (end if end > half else path.length) - (begin if begin < half else 0.0)
        assert seen > 0.9 * path.length
        taken = time[cutting][-1] - time[cutting][0]
        assert 0.98 * seen / 50.0 < taken < 1.25 * path.length / 50.0
