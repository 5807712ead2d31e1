"""What the steps of one fit of an axis share: the log, where it is cut, and what is known before."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from leadscrew.identify.axis.linear_stage import SHARE, two_ways
from leadscrew.identify.axis.parameters import checked, unlike
from leadscrew.identify.axis.record import Record, choose_length, record_of
from leadscrew.kernel import validate
from leadscrew.logs.arrays import unlike as unlike_units
from leadscrew.util.errors import ValueRefused

if TYPE_CHECKING:
    from leadscrew.identify.axis.backlash import Backlash
    from leadscrew.identify.axis.cascade import Cascade
    from leadscrew.logs import AxisLog

Progress = Callable[[str, float], None]
REFINE = ("auto", "none", "open", "windows", "closed")
MODELS = ("auto", "coulomb", "stribeck", "lugre")
LEAST = 400
"""Samples that each part of a cut log must have."""
TURNS = 0.1
"""Share of the moving time before the cut that should go the other way."""
REST = 41
"""Samples that a stand-still has at least."""


@dataclass
class Job:
    """What the steps of one fit share."""

    log: AxisLog
    record: Record
    cut: int
    """First sample of the hold-out."""
    length: int
    both_ways: bool
    given: dict[str, float]
    say: Progress
    follows: bool = False
    """Whether the simulated windows leave no more than the sensor's noise."""
    dwell: Backlash | None = None
    """What reversals say of a play, where the simulated windows leave more."""
    doubtful: set[str] = field(default_factory=set)
    """Mass and delay, where least squares and simulation contradict one another about them."""
    notes: list[str] = field(default_factory=list)

    @cached_property
    def training(self) -> Record:
        """What parameters come from."""
        return self.record.part(0, self.cut)

    def stretch(self, first: int, last: int) -> AxisLog:
        """The log from sample ``first`` to ``last`` (left out)."""
        time = self.log.time
        return self.log.part(float(time[first]), float(time[last - 1]))


def prepared(
    log: AxisLog, holdout: float, delay: float | None, given: dict[str, float], model: str, refine: str,
    cascade: Cascade | None, progress: Progress | None,
) -> tuple[Job, float | None]:  # fmt: skip
    """The job, and the delay where it is known, s.

    Raises:
        ValueRefused, NameUnknown, DataError: as :func:`leadscrew.identify.axis.fit.identify_axis`.
    """
    validate.one_of("model", model, list(MODELS))
    validate.one_of("refine", refine, list(REFINE))
    if refine == "closed" and cascade is None:
        raise ValueRefused("refine = 'closed': give the cascade that was active while the log was made")
    share = validate.number("holdout", holdout, "")
    if not 0.0 <= share <= 0.8:
        raise ValueRefused(f"holdout = {share:g}: must lie from 0 to 0.8")
    known = checked(given)
    if log.force_per_drive is not None:
        known.setdefault("force_per_drive", float(log.force_per_drive))
        if known["force_per_drive"] != log.force_per_drive:
            raise ValueRefused(
                f"given.force_per_drive = {known['force_per_drive']:g}: the log has {log.force_per_drive:g}; give one"
            )
    if "force_per_drive" not in known and (missing := unlike_units(log.unit)):
        raise ValueRefused(f"{log.source}: {missing}")
    if delay is not None:
        known["delay_s"] = validate.number("delay", delay, "s")
        if known["delay_s"] < 0.0:
            raise ValueRefused(f"delay = {delay:g} s: a drive cannot act before it is given")
    force = known.get("force_per_drive", 1.0)
    if cascade is not None and cascade.kv * force < 0.0:
        raise ValueRefused(
            f"cascade.kv = {cascade.kv:g}: must have the sign of the force of the drive, {force:g}; with the other "
            "one the loop pushes away from its command"
        )
    record = record_of(log, known.get("force_per_drive", 1.0))
    n = len(record.position)
    turns = _both_ways(record, n - round(share * n))
    cut = _at_rest(record, turns)
    cut = cut if _both_ways(record, cut) == cut else turns
    job = Job(log, record, cut, 0, True, known, progress or (lambda what, done: None))
    if share > 0.0 and min(cut, n - cut) < LEAST:
        job.notes.append(
            f"The log has {n} samples: too short to keep {100.0 * share:.0f} % of it for validation; all of it is "
            "estimation data."
        )
        job.cut = n
    job.length = choose_length(job.training)
    return job, known.get("delay_s")


def _both_ways(record: Record, cut: int) -> int:
    """The cut, moved by up to a quarter of the log to where what is before it goes both ways, if the log does so."""
    n = len(record.position)
    if cut >= n or not two_ways(record):
        return cut
    s = record.samples
    ahead, back = (np.concatenate([[0, 0], np.cumsum(~s.slow & (w * s.smooth > 0.0)), [0]]) for w in (1.0, -1.0))
    at = np.arange(max(2, cut - n // 4), min(n - 1, cut + n // 4))
    fewer = np.minimum(ahead[at], back[at])
    for share in (TURNS, 2.0 * SHARE):
        good = at[fewer >= share * np.maximum(ahead[at] + back[at], 1)]
        if good.size:
            return int(good[np.argmin(np.abs(good - cut))])
    return cut


def _at_rest(record: Record, cut: int) -> int:
    """The nearest stand-still, within a tenth of the log: there a simulation's start is known best."""
    slow, n = record.samples.slow, len(record.position)
    low, high = max(0, cut - n // 10), min(len(slow), cut + n // 10)
    if cut >= n or high <= low:
        return cut
    long_enough = np.convolve(slow[low:high], np.ones(REST), "same") >= REST - 0.5
    at = low + np.flatnonzero(long_enough)
    return int(at[np.argmin(np.abs(at - cut))]) if at.size else cut


def ways(job: Job, symmetric: bool | None) -> bool | None:
    """Whether the models are symmetric, not, or both are tried."""
    job.both_ways = two_ways(job.training)
    if not job.both_ways:
        job.notes.append(
            "The part that trains moves one way only: friction backwards is taken as forwards, and a constant force is "
            "counted as Coulomb friction."
        )
        return True
    if unlike(job.given):
        return False
    return symmetric
