"""A screw-compensation table as LinuxCNC reads it."""

import numpy as np

from leadscrew.analysis.positioning import Correction
from leadscrew.export.screw_compensation import MOST
from leadscrew.util.errors import DataError


def read_compensation(text: str, kind: int = 0) -> Correction:
    """A table as LinuxCNC reads it.

    Raises:
        DataError: what LinuxCNC would refuse, or would stop at without a word.
    """
    rows: list[list[float]] = []
    for number, line in enumerate(text.splitlines(), 1):
        try:
            cells = [float(x) for x in line.split()]
        except ValueError:
            cells = []
        if len(cells) != 3 or not np.all(np.isfinite(cells)):
            raise DataError(f"screw compensation, line {number}: {line!r} is not three numbers; LinuxCNC stops there")
        if rows and not cells[0] > rows[-1][0]:
            raise DataError(f"screw compensation, line {number}: {cells[0]:g} does not rise above {rows[-1][0]:g}")
        rows.append(cells)
    if not 0 < len(rows) <= MOST:
        raise DataError(f"screw compensation: {len(rows)} points; LinuxCNC takes 1 to {MOST}")
    nominal, forward, reverse = np.array(rows).T
    if kind == 0:
        return Correction(nominal, nominal - forward, nominal - reverse)
    return Correction(nominal, forward, reverse)
