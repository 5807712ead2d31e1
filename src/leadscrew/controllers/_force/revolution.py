"""Where the carriage stood one revolution of the spindle ago: from that, the feed per revolution that is cut now.

    f = x(theta) - x(theta - 1),      n = 60 (theta_k - theta_(k-1)) / T

The readings of the last :data:`ROOM` samples are kept by time and read by angle, with straight lines between samples,
so a spindle that droops is dealt with. In the first revolution the work is uncut: ``x(theta - 1)`` is where the
carriage stood at the first sample, the force then 0. A spindle so slow that a revolution takes more than ``ROOM``
samples (94 1/min at 20 ms), or a history that begins in the cut (after a bumpless start), gives ``whole = 0``: then
nothing must be concluded from it.

Source: ours, for the study ``grey_turning``.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from leadscrew.kernel.parameters import Doc

ROOM = 32
"""Samples that are kept."""
NEVER = -1e300
"""Angle of a place that was not written yet."""


class Turns(NamedTuple):
    """The last readings."""

    turns: Annotated[np.ndarray, Doc("revolutions of the spindle")]
    travel: Annotated[np.ndarray, Doc("travel of the carriage, mm")]
    force: Annotated[np.ndarray, Doc("force, N")]
    at: Annotated[int, Doc("place of the next reading")] = 0
    filled: Annotated[int, Doc("readings so far, at most ROOM")] = 0
    first: Annotated[float, Doc("travel of the carriage at the first sample, mm")] = 0.0
    last: Annotated[float, Doc("revolutions at the last sample")] = 0.0
    uncut: Annotated[float, Doc("1: the work was uncut at the first sample; 0 after a bumpless start")] = 1.0


class Before(NamedTuple):
    """One revolution ago."""

    travel: float
    """Way of the carriage, mm."""
    force: float
    """Force, N."""
    whole: float
    """1 if it is known, else 0."""


def nothing_yet(uncut: float = 1.0) -> Turns:
    """No reading."""
    return Turns(np.full(ROOM, NEVER), np.zeros(ROOM), np.zeros(ROOM), uncut=uncut)


def speed(s, turns, rpm, dt):
    """Spindle speed since the last sample, 1/min; ``rpm`` at the first one."""
    return 60.0 * (turns - s.last) / dt if s.filled > 0 else rpm


def recorded(s, travel, turns, force):
    """One reading more."""
    s.turns[s.at] = turns
    s.travel[s.at] = travel
    s.force[s.at] = force
    return Turns(
        s.turns, s.travel, s.force, s.at + 1 if s.at + 1 < ROOM else 0, min(s.filled + 1, ROOM),
        s.first if s.filled > 0 else travel, turns, s.uncut,
    )  # fmt: skip


def one_ago(s):
    """What was read one revolution before the last reading."""
    place = s.last - 1.0
    older, newer = NEVER, -NEVER
    x_older, x_newer, f_older, f_newer = 0.0, 0.0, 0.0, 0.0
    for i in range(ROOM):
        angle = s.turns[i]
        below = angle <= place and angle > older
        older, x_older, f_older = (
            angle if below else older, s.travel[i] if below else x_older, s.force[i] if below else f_older
        )  # fmt: skip
        above = angle > place and angle < newer
        newer, x_newer, f_newer = (
            angle if above else newer, s.travel[i] if above else x_newer, s.force[i] if above else f_newer
        )  # fmt: skip
    known = older > NEVER
    share = (place - older) / (newer - older) if known else 0.0
    begun = s.uncut > 0.5 and s.filled < ROOM
    return Before(
        x_older + share * (x_newer - x_older) if known else s.first,
        f_older + share * (f_newer - f_older) if known else 0.0,
        1.0 if known or begun else 0.0,
    )
