"""The README of a test move: safety first, then steps, then what the log will tell."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from leadscrew.escape import markdown_code
from leadscrew.identify.excite.limits import SHARE

if TYPE_CHECKING:
    from leadscrew.identify.excite.design import Proposal
    from leadscrew.identify.excite.files import Machine


def readme(proposal: Proposal, machine: Machine) -> str:
    """Markdown."""
    from leadscrew.identify.excite.files import SHOWN, header

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
