"""LinuxCNC's screw-compensation table from a positioning test.

LinuxCNC adds a correction to the commanded position of a joint before it goes to the motor:

    motor position = joint position + c+(joint position)    while the joint moves in positive direction
    motor position = joint position + c-(joint position)    while it moves in negative direction

with ``c`` linear between the points of the table, constant beyond its ends, and kept while the joint stands. After a
reversal the correction is moved over with half the joint's acceleration and speed. An axis that ends ``d`` beyond its
target needs the correction ``-d``, so with the mean deviations ``x+_i`` and ``x-_i`` of ISO 230-2 at the target ``P_i``
a row of the file is

| ``COMP_FILE_TYPE`` | nominal | forward | reverse |
|---|---|---|---|
| 0 | ``P_i`` | ``P_i + x+_i``: where the axis really was | ``P_i + x-_i`` |
| 1 | ``P_i`` | ``-x+_i``: what to add | ``-x-_i`` |

LinuxCNC reads three numbers a line and stops, silently, at the first line that is something else: so the file has no
header and no comment. Nominal positions must rise; 256 points are the most. A joint with a table does not use its
``BACKLASH``: the difference of the two columns takes its place. All of this is from LinuxCNC's source
(``usrmotintf.cc``, ``command.c`` and ``control.c`` of ``src/emc/motion``) and held against the real one by a test.
"""

from __future__ import annotations

from leadscrew.analysis.positioning import Positioning, correction
from leadscrew.util.errors import ValueRefused

MOST = 256
"""Points of a table (``EMCMOT_COMP_SIZE``)."""
TYPES = (0, 1)
UNITS = {"mm": (1.0, 6), "inch": (25.4, 7)}
"""Millimetres in the machine's unit, and decimals: nanometres."""


def screw_compensation(test: Positioning, kind: int = 0, unit: str = "mm") -> str:
    """The text of a ``COMP_FILE`` that takes the mean deviations of a test away.

    Args:
        test: measured in both directions, without any other table or backlash compensation at work.
        kind: the ``COMP_FILE_TYPE``, 0 or 1.
        unit: of the machine (``LINEAR_UNITS``): ``mm`` or ``inch``.

    Raises:
        ValueRefused: a test of one direction, more targets than LinuxCNC takes, or another kind or unit.
    """
    if kind not in TYPES:
        raise ValueRefused(f"COMP_FILE_TYPE = {kind!r}: expected 0 (positions) or 1 (trims)")
    if unit not in UNITS:
        raise ValueRefused(f"unit = {unit!r}: expected {' or '.join(UNITS)}")
    if len(test.targets_mm) > MOST:
        raise ValueRefused(f"{len(test.targets_mm)} targets: LinuxCNC takes at most {MOST} points")
    found = correction(test)
    size, decimals = UNITS[unit]
    rows = []
    for nominal, *added in zip(*found, strict=True):
        columns = [nominal - x for x in added] if kind == 0 else added
        rows.append(" ".join(f"{x / size:.{decimals}f}" for x in (nominal, *columns)))
    return "\n".join(rows) + "\n"


def ini_lines(name: str, kind: int = 0, joint: str = "n") -> str:
    """What to write into the INI file of LinuxCNC for a table of that name."""
    return f"[JOINT_{joint}]\nCOMP_FILE = {name}\nCOMP_FILE_TYPE = {kind}\n"
