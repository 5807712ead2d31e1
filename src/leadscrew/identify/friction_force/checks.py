"""What is odd about the signals of a friction log, by the checks of :mod:`leadscrew.logs`.

Of an axis a top speed above 20 m/s, a travel above 100 m or a period above 0.5 s is refused as a wrong unit. A
tribometer may do that, so here it is said, with the option that mends it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from leadscrew.kernel.errors import DataError
from leadscrew.logs.finding import Finding
from leadscrew.logs.measure import Motion, motion
from leadscrew.logs.plausible import check_drive, check_units
from leadscrew.logs.sampling import Place, clock

GAP = 1.5
"""Times the usual period that make a gap."""
INERTIA = 0.3
"""Share of the force's variance that a mass must explain for it to be said."""
GAPS = 0.05
"""Share of steps above which uneven times are the way of the log, not gaps."""


def check_time(t: np.ndarray, source: str, place: Place) -> list[Finding]:
    """Passes where times rise; says gaps, and a period that looks like another unit.

    Raises:
        DataError: a time that does not rise.
    """
    steps = np.diff(t)
    seen = clock(t, place)
    back = np.flatnonzero(steps <= 0.0)
    if len(back):
        faults = [f.sentence for f in seen.findings if f.severity == "refused"]
        k = int(back[0])
        plain = f"{place(k + 1)}: the time {t[k + 1]:g} s does not rise above {t[k]:g} s"
        raise DataError(f"{source}: {faults[0] if faults else plain}")
    found = [f._replace(severity="warning") for f in seen.findings if f.kind == "unit"]
    usual = float(np.median(steps))
    gaps = np.flatnonzero(steps > GAP * usual)
    # an adaptive step differs from sample to sample; a gap is an exception
    if not len(gaps) or len(gaps) > GAPS * len(steps):
        return found
    first, last = int(gaps[0]), int(gaps[-1])
    many = "1 step of time is" if len(gaps) == 1 else f"{len(gaps)} steps of time are"
    return [*found, Finding(
        "gap", "note",
        f"{many} longer than {GAP:g} periods of {usual:g} s (between {t[first]:g} and {t[last + 1]:g} s, the longest "
        f"{steps.max():g} s); every sample is taken with its own step",
    )]  # fmt: skip


def check_motion(
    t: np.ndarray, force: np.ndarray, position: np.ndarray, speed: np.ndarray, unit: str, source: str
) -> list[Finding]:
    """Says speeds and travels that look like another unit.

    Raises:
        DataError: force and position are swapped.
    """
    period = float(np.median(np.diff(t)))
    arrays = {"drive": force, "position": position}
    if any(f.kind == "swapped" for f in check_drive(arrays, motion(position, period), period, unit, None)):
        raise DataError(
            f"{source}: the position looks like a force and the force like a position: the two columns are swapped; "
            "name them with --force NAME --position NAME"
        )
    # Times may be uneven, so the speed is the record's own; its acceleration is not looked at.
    moves = Motion(speed, np.zeros(len(speed)), 0)
    found = [f for f in check_units(position, moves, period, unit) if f.severity == "refused"]
    return [*(f._replace(severity="warning") for f in found), *_mass(t, force, position, period, unit)]


def _mass(t: np.ndarray, force: np.ndarray, position: np.ndarray, period: float, unit: str) -> list[Finding]:
    """A force that is mostly a mass times its acceleration is that of a drive, not of friction."""
    steps = np.diff(t)
    if float(np.ptp(steps)) > 0.1 * period:
        return []
    moves = motion(position, period)
    kept = slice(moves.margin, len(force) - moves.margin or None)
    speed, acceleration = moves.speed[kept], moves.acceleration[kept]
    size = float(np.std(acceleration)) or 1.0
    terms = np.column_stack([np.ones(len(speed)), np.sign(speed), speed / (np.std(speed) or 1.0), acceleration / size])
    spread = float(np.var(force[kept]))
    shares = []
    for count in (3, 4):
        values, *_ = np.linalg.lstsq(terms[:, :count], force[kept], rcond=1e-10)
        shares.append(1.0 - float(np.var(force[kept] - terms[:, :count] @ values)) / spread if spread else 0.0)
    if shares[1] < 0.9 or shares[1] - shares[0] < INERTIA:
        return []
    mass = abs(float(values[3])) / size
    kind = "kg" if unit == "m" else "kg m^2"
    said = (
        f"{100.0 * (shares[1] - shares[0]):.0f} % of the force is that of {mass:.3g} {kind} speeding up: it looks like "
        "the force of a drive, not of friction; leadscrew identify axis takes mass and friction apart"
    )
    return [Finding("mass", "warning", said)]


def doubles(notes: Sequence[str], used: Sequence[str]) -> list[Finding]:
    """What the file says of two columns of one name, where one of them is used."""
    return [
        Finding("columns", "warning", f"{note}; {name!r} was taken")
        for note in notes
        for name in used
        if f"second {name!r}" in note or f"called {name!r}" in note
    ]
