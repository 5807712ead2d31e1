"""A command that was logged, played again.

Between two samples it runs in a straight line, beyond the last it stands there. Speed and acceleration are differences
of the position over two samples, taken when the block is made: of a command that was logged with rounding they are
rough, and so is a feed-forward of its acceleration.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from leadscrew.kernel import validate
from leadscrew.kernel.block import Block, reference
from leadscrew.kernel.parameters import Doc, Gt, Unit
from leadscrew.references._motion import Motion
from leadscrew.util.errors import DataError, entry_point


class LoggedParams(NamedTuple):
    """Samples of the command, in its unit."""

    position: Annotated[NDArray[np.float64], Doc("at each sample")] = np.zeros(2)
    speed: Annotated[NDArray[np.float64], Doc("at each sample, per second")] = np.zeros(2)
    acceleration: Annotated[NDArray[np.float64], Doc("at each sample, per s^2")] = np.zeros(2)
    interval: Annotated[float, Unit("s"), Gt(0), Doc("between two samples")] = 1e-3


def logged(p, t):
    """The logged command as a :class:`~leadscrew.references.Motion`."""
    last = p.position.shape[0] - 1
    place = min(t / p.interval, last - 1e-9)
    row = int(place)
    share = place - row
    going = 1.0 if t < last * p.interval else 0.0
    return Motion(
        p.position[row] + share * (p.position[row + 1] - p.position[row]),
        going * (p.speed[row] + share * (p.speed[row + 1] - p.speed[row])),
        going * (p.acceleration[row] + share * (p.acceleration[row + 1] - p.acceleration[row])),
    )


@entry_point
def logged_command(position: np.ndarray, interval: float, unit: str = "") -> Block:
    """The reference that plays ``position``, sampled every ``interval`` seconds, again from t = 0 on.

    Raises:
        DataError: fewer than three samples, or one that is no finite number.
        ValueRefused: an interval that is not above 0.
    """
    validate.positive("interval", interval, "s")
    x = np.array(position, dtype=np.float64)
    if x.ndim != 1 or len(x) < 3:
        raise DataError(f"a logged command of {x.size} samples; expected three or more in a row")
    bad = np.flatnonzero(~np.isfinite(x))
    if len(bad):
        raise DataError(f"sample {bad[0] + 1} of the logged command is {x[bad[0]]}, not a finite number")
    speed = np.gradient(x, interval)
    return reference(LoggedParams(x, speed, np.gradient(speed, interval), interval), unit=unit)(logged)
