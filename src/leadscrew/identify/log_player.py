"""A log played on a model: the logged signal as a reference, and one batch of runs from any of its samples.

A run starts at any sample of the log with a position and a speed of its own, so windows and points of a fit are runs of
one ``Loop.batch``. A delay of the drive is whole periods, taken by the loop, and a part of one, taken by the plant.
Before the first sample the signal is that of the first sample, after the last that of the last.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from leadscrew.kernel.block import Block, controller, reference
from leadscrew.kernel.loop import Loop
from leadscrew.kernel.parameters import Doc
from leadscrew.util.errors import ValueRefused

LOST = 1e6
"""m; stands for a run that diverged."""


def row_at(first: float, t: float, dt: float) -> float:
    """The sample of the period that begins at ``t``, in a run from sample ``first`` on; it may lie outside the log."""
    return first + math.floor(t / dt + 0.5)


class Samples(NamedTuple):
    """A logged signal, and where a run begins."""

    first: Annotated[float, Doc("sample that the run starts at")] = 0.0
    values: Annotated[NDArray[np.float64], Doc("held from each sample to the next")] = np.zeros(1)


def sample_at(p, t, dt):
    """The signal of the period that begins at ``t``."""
    return p.values[int(min(max(row_at(p.first, t, dt), 0.0), p.values.shape[0] - 1))]


def played_signal(values: np.ndarray) -> Block:
    """The reference that plays a signal."""
    return reference(Samples(values=lengthened(values)), name="played signal")(sample_at)


@controller()
def as_logged(command):
    """Hands the logged drive on."""
    return command


def lengthened(values: np.ndarray) -> np.ndarray:
    """The signal with its last value repeated, to a length that other logs have too.

    Compiled code knows the lengths of its arrays. Lengths of four steps in each octave let logs of all lengths share
    it, for at most a quarter more memory; a block that plays a signal holds its last value anyway.
    """
    step = 2 ** max(0, (len(values) - 1).bit_length() - 3)
    return np.pad(np.asarray(values, dtype=np.float64), (0, -len(values) % step), mode="edge")


class Starts(NamedTuple):
    """Where runs start: sample, position and speed."""

    first: np.ndarray
    position: np.ndarray
    speed: np.ndarray

    @classmethod
    def together(cls, state: tuple[float, float], runs: int) -> Starts:
        """All runs from the first sample with the same position and speed."""
        return cls(np.zeros(runs), *(np.full(runs, value) for value in state))


class Player(NamedTuple):
    """A loop that plays a log on ``plant.axis``, and by which keys it takes delay and start."""

    loop: Loop
    delay: str
    """Whole periods of delay."""
    starts: tuple[str, ...]
    """Slots with a ``start_position`` and a ``start_speed``."""
    first: str | None = None
    """Sample that a run starts at; None: only the first."""
    longest: float = math.inf
    """Whole periods of delay that the loop can take."""

    def play(
        self, points: Sequence[Mapping[str, float]], starts: Starts, samples: int, delays: Sequence[float]
    ) -> np.ndarray:
        """Positions ``[run, sample]``: run ``i`` has the plant's values ``points[i]``, its start and its delay, s.

        A run that diverges has :data:`LOST` in it.

        Raises:
            ValueRefused: a delay that the loop cannot take.
        """
        periods = np.maximum(np.asarray(delays, dtype=np.float64), 0.0) / self.loop.period
        whole = np.floor(periods + 1e-9)
        if whole.max() > self.longest:
            raise ValueRefused(
                f"delay_s = {max(delays):g}: a closed loop is simulated with up to "
                f"{self.longest * self.loop.period:g} s"
            )
        varied = {f"plant.axis.{key}": np.array([p[key] for p in points]) for key in points[0]}
        varied |= {self.delay: whole, "plant.part": np.maximum(periods - whole, 0.0)}
        if self.first is not None:
            varied[self.first] = np.asarray(starts.first, dtype=np.float64)
        for slot in self.starts:
            varied |= {f"{slot}.start_position": starts.position, f"{slot}.start_speed": starts.speed}
        batch = self.loop.batch(samples * self.loop.period, varied, runs=len(points), record=("actual.position",))
        table = np.asarray(batch["actual.position"])
        # a start that is given to the plant in its first step comes after its first output was read
        table[:, 0] = starts.position
        return np.clip(np.nan_to_num(table, nan=LOST, posinf=LOST, neginf=-LOST), -LOST, LOST)
