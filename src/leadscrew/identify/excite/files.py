"""A test move as a folder: reference, program, recorder, settings, and how to use them.

- ``reference.csv``: time, position, velocity, acceleration and stroke, a row a period;
- ``move.ngc``: the same for LinuxCNC: ``G61.1`` (stop exactly at each end), ``G1`` with F, ``G4``;
- ``record.hal``: LinuxCNC's ``sampler`` on the signals of the axis, in the servo thread;
- ``record.sh``: writes ``log.txt`` with a header line that ``leadscrew identify axis`` reads as it is;
- ``proposal.json``, ``README.md``.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from leadscrew.identify.excite.design import Proposal
from leadscrew.identify.excite.move import SHARE
from leadscrew.util.atomic import atomic_folder
from leadscrew.util.errors import ValueRefused
from leadscrew.util.escape import markdown_code

if TYPE_CHECKING:
    from leadscrew.identify.excite.design import Proposal


CHANNELS = 3
DEPTH = 20000
"""Samples that the recorder holds while nobody reads: 20 s at 1 kHz."""
TO_START = 0.1
"""Of the top speed, to the start of the move: from wherever the axis stands."""
SHOWN = {"m": ("mm", 1000.0), "rad": ("deg", 180.0 / math.pi)}


@dataclass(frozen=True)
class Machine:
    """Names on the user's machine."""

    axis: str = "X"
    command: str = ""
    """HAL signals; empty: ``x-pos-cmd``, ``x-pos-fb``, ``x-output`` for X, as PnCConf of LinuxCNC names them."""
    feedback: str = ""
    output: str = ""
    drive_unit: str = "V"
    thread: str = "servo-thread"

    def signals(self) -> tuple[str, str, str]:
        """Commanded position, measured position, drive."""
        x = self.axis.casefold()
        return self.command or f"{x}-pos-cmd", self.feedback or f"{x}-pos-fb", self.output or f"{x}-output"


def checked(machine: Machine) -> Machine:
    """The names, where HAL and G-code take them.

    Raises:
        ValueRefused: a letter that is no axis, or a name with a blank.
    """
    if machine.axis.upper() not in tuple("XYZABCUVW"):
        raise ValueRefused(f"axis = {machine.axis!r}: allowed are X, Y, Z, A, B, C, U, V, W")
    for name in (*machine.signals(), machine.thread, machine.drive_unit.replace(" ", "")):
        if not name or any(c == " " or not c.isprintable() or c in "\"'#$\\[]" for c in name):
            raise ValueRefused(f"{name!r}: a name of a signal, a thread or a unit has no blanks, quotes or brackets")
    return machine


def write(proposal: Proposal, folder: str | Path, machine: Machine | None = None) -> None:
    """Writes the folder; complete, or not at all.

    Raises:
        ValueRefused: a name that HAL or G-code does not take.
        DataError: the folder exists already and is not empty, or cannot be written.
    """
    from leadscrew.util.strict_json import strict

    names = checked(machine or Machine())
    with atomic_folder(folder) as place:
        (place / "reference.csv").write_text(reference_csv(proposal), encoding="utf-8")
        (place / "move.ngc").write_text(program(proposal, names.axis.upper()), encoding="utf-8")
        (place / "record.hal").write_text(recorder(names), encoding="utf-8")
        (place / "record.sh").write_text(record_script(proposal, names), encoding="utf-8")
        mode = (place / "record.sh").stat().st_mode
        (place / "record.sh").chmod(mode | (mode & 0o444) >> 2)  # whoever may read it may run it
        found = {"schema_version": 1, "kind": "leadscrew excite", **proposal.as_dict()}
        text = json.dumps(strict(found), indent=1, allow_nan=False)
        (place / "proposal.json").write_text(text + "\n", encoding="utf-8")
        (place / "README.md").write_text(readme(proposal, names), encoding="utf-8")


def reference_csv(proposal: Proposal) -> str:
    """The samples in mm or deg, to a picometre or so."""
    unit, scale = SHOWN[proposal.belief.unit]
    seen = proposal.samples
    head = f"time [s],position [{unit}],velocity [{unit}/s],acceleration [{unit}/s^2],stroke"
    rows = np.column_stack([seen.time, *(scale * np.column_stack(seen[1:4])).T, seen.stroke])
    return "\n".join([head, *(f"{t:.9g},{x:.9f},{v:.9g},{a:.9g},{k:.0f}" for t, x, v, a, k in rows), ""])


def program(proposal: Proposal, axis: str) -> str:
    """The strokes as G-code, in mm or deg; LinuxCNC stops at the end of each."""
    move, (unit, scale) = proposal.move, SHOWN[proposal.belief.unit]
    low, high = (scale * x for x in (move.limits.low, move.limits.high))
    lines = [
        "(leadscrew excite 1)",
        f"({axis} from {low:g} to {high:g} {unit} at most, {scale * move.limits.speed:g} {unit}/s)",
        f"({axis} must be free to move over this travel; the other axes stand)",
        "G21 G90 G40 G49 G80 G94",
        "G61.1",
        f"G1 {axis}{_place(scale * move.start)} F{60.0 * scale * TO_START * move.limits.speed:.6g}",
        "G4 P1.0",
    ]
    purpose, here = "", move.start
    for stroke in move.strokes:
        if stroke.purpose != purpose:
            purpose = stroke.purpose
            lines.append(f"({purpose})")
        if stroke.end != here:
            feed = 60.0 * scale * min(stroke.speed, SHARE * move.limits.speed)
            lines.append(f"G1 {axis}{_place(scale * stroke.end)} F{feed:.6g}")
        lines.append(f"G4 P{stroke.rest:.3f}")
        here = stroke.end
    return "\n".join([*lines, "G64", "M2", ""])


def _place(value: float) -> str:
    return f"{value:.6f}"


def recorder(machine: Machine) -> str:
    """HAL commands: load after the machine's own files, for example as a last ``HALFILE`` of its ini file."""
    command, feedback, output = machine.signals()
    return "\n".join([
        "# leadscrew excite: records an axis in the servo thread. Load it as the last HALFILE of the ini file.",
        f"loadrt sampler depth={DEPTH} cfg={'f' * CHANNELS}",
        f"net {command} => sampler.0.pin.0",
        f"net {feedback} => sampler.0.pin.1",
        f"net {output} => sampler.0.pin.2",
        f"addf sampler.0 {machine.thread}",
        "# record.sh switches it on: before, nobody reads.",
        "setp sampler.0.enable 0",
        "",
    ])  # fmt: skip


def samples_to_record(proposal: Proposal) -> int:
    """Half as many again as the move takes, and ten seconds: the run to its start, stops between strokes."""
    return math.ceil((1.5 * proposal.move.duration + 10.0) / proposal.belief.period)


def header(proposal: Proposal, machine: Machine) -> str:
    """The header line of the log: columns by the names and units that ``identify axis`` knows."""
    unit, _ = SHOWN[proposal.belief.unit]
    period = f"{proposal.belief.period:.9g}"
    return f"# time [{period} s] command [{unit}] position [{unit}] drive [{machine.drive_unit.replace(' ', '')}]"


def record_script(proposal: Proposal, machine: Machine) -> str:
    """Shell: header, then the recorder, until enough samples or Ctrl-C."""
    return "\n".join([
        "#!/bin/sh",
        "# leadscrew excite: run this in a terminal, then start move.ngc; Ctrl-C when the move has ended.",
        'out="${1:-log.txt}"',
        'if [ -e "$out" ]; then echo "$out exists already; name another file" >&2; exit 1; fi',
        f"echo '{header(proposal, machine)}' > \"$out\"",
        "halcmd setp sampler.0.enable 1",
        f'halsampler -t -n {samples_to_record(proposal)} >> "$out" &',
        "trap 'kill $! 2> /dev/null' INT TERM",
        "wait $!",
        "halcmd setp sampler.0.enable 0",
        "",
    ])  # fmt: skip


def readme(proposal: Proposal, machine: Machine) -> str:
    """Markdown."""
    unit, scale = SHOWN[proposal.belief.unit]
    limits, axis = proposal.limits, machine.axis.upper()
    low, high = scale * limits.low, scale * limits.high
    lowest, highest = (scale * f(proposal.samples.position) for f in (min, max))
    command, feedback, output = map(markdown_code, machine.signals())
    jerk = (
        f"\n- The jerk in `reference.csv` stays below {scale * limits.jerk:g} {unit}/s^3. LinuxCNC 2.9 does not limit "
        "jerk: played from `move.ngc` the acceleration jumps. Use the CSV where that is not allowed."
        if limits.jerk
        else ""
    )
    return f"""# A test move for {axis}

{proposal.move.duration:.0f} s at {proposal.belief.period:g} s a sample, made by `leadscrew excite`.

## Safety

- {axis} moves from {lowest:.4g} to {highest:.4g} {unit} ({low:g} to {high:g} allowed), at
  {scale * limits.speed * SHARE:.4g} {unit}/s and {scale * limits.acceleration * SHARE:.4g} {unit}/s^2 at most.
  No tool, no workpiece, nothing in the way.
- In the ini file set `MAX_ACCELERATION` of the axis and of its joint to
  {scale * limits.acceleration * SHARE:.6g}: G-code cannot say it, and `move.ngc` runs at what stands there.
  `MAX_VELOCITY` must be at least {scale * limits.speed * SHARE:.6g}.{jerk}
- Run it once with the feed override at 20 %, a hand on the emergency stop; then at 100 %, which is the log to keep.
- Software limits stay on, and `FERROR` stays as it is: a test that trips it asks too much of the axis. Propose one with
  lower limits.

## Steps with LinuxCNC

1. Load `record.hal` as the last `HALFILE` of the ini file. It takes the signals {command}, {feedback} and
   {output}; where yours are called otherwise (`halcmd show sig`), change the three `net` lines or give their names to
   `leadscrew excite`.
2. Home the machine. In a terminal: `./record.sh log.txt`. In LinuxCNC: open `move.ngc`, start it.
3. When it has ended: Ctrl-C in the terminal, if it still runs.
4. `leadscrew identify axis log.txt`

The first line of the log says what its columns are:

    {header(proposal, machine)}

## Steps with another control

Play `reference.csv` (columns: s, {unit}, {unit}/s, {unit}/s^2) as set points, and record time, command, position and
the drive's command or current at every period, with a header line such as `time [s],command [{unit}],position [{unit}],
drive [{machine.drive_unit}]`.

## What its log will tell

Half of the 95 % interval, from one of the two passes; the second is kept to judge the fit.

| parameter | believed | interval | |
|---|---|---|---|
{_table(proposal)}
"""


def _table(proposal: Proposal) -> str:
    rows = []
    for p in proposal.predicted:
        half = f"+- {p.half:.3g}" if math.isfinite(p.half) else "-"
        percent = f" ({p.percent:.2g} %)" if math.isfinite(p.percent) else ""
        rows.append(f"| {p.key} | {p.value:.4g} | {half}{percent} | {p.verdict}{': ' + p.why if p.why else ''} |")
    return "\n".join(rows)
