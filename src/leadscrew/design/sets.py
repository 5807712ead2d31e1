"""Step 4 of a design: how many sets, and where.

Equation (10) of Long et al. (2014) can be read in three ways (:mod:`leadscrew.fuzzy.grids`), and none is
preferred here: the count is taken from (10) only under a reading that is named, and gives evenly spaced sets. Centres
may be given instead, or a number of sets. With nothing given the paper's printed centres stand, and the step says that
they follow from no count.

Whatever the sets, the error that they guarantee for the curvatures is ``h^2 / 8 (u_ee + u_cc)`` in the widest interval.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from leadscrew.controllers.vud.universe import CENTRES
from leadscrew.design.bending import Bending
from leadscrew.fuzzy.grids import (
    PartitionCount,
    Reading,
    equal_sets_for,
    even,
    interpolation_bound,
    partition,
    partition_count,
)
from leadscrew.fuzzy.partition import Partition
from leadscrew.kernel.errors import ValueRefused

ACCURACY = 0.05
"""Of the paper, in duty."""
MOST_SETS = 99


@dataclass(frozen=True)
class Sets:
    """The sets of e, ec and the duty, and what (10) says about their number."""

    partition: Partition
    source: str
    """Where the centres come from."""
    accuracy: float
    count: PartitionCount | None
    """Equation (10) under each reading; none without curvatures."""
    reading: Reading | None
    bound: tuple[float, ...] | None
    """Guaranteed error of these centres in each interval; none without curvatures."""
    equal_for: int | None
    """Evenly spaced sets that the accuracy needs."""

    def lines(self) -> list[str]:
        """The step as text."""
        centres = ", ".join(
            f"{label} {c:g}" for label, c in zip(self.partition.labels, self.partition.centres, strict=True)
        )
        lines = []
        if self.count is None:
            lines.append("number of sets by (10): undecided, since there is no curvature")
        else:
            c = self.count
            lines.append(
                f"number of sets by (10) for {self.accuracy:g}: {c.half} read as half, {c.full} as full, "
                f"{c.sets_of_intervals} as intervals ({c.intervals} of them)"
            )
            taken = f"taken as {self.reading}, as asked" if self.reading else "none preferred: --reading takes one"
            lines.append(taken)
        lines.append(f"{len(self.partition)} sets, {self.source}: {centres}")
        if self.bound is not None:
            lines.append(
                f"they guarantee an error of {max(self.bound):.3f} (least in an interval {min(self.bound):.3f}); "
                f"{self.accuracy:g} needs {self.equal_for} evenly spaced sets"
            )
        return lines

    def as_dict(self) -> dict[str, Any]:
        """The same as plain data."""
        return {
            "centres": list(self.partition.centres),
            "labels": list(self.partition.labels),
            "source": self.source,
            "accuracy": self.accuracy,
            "count": None if self.count is None else self.count._asdict(),
            "reading": self.reading,
            "bound": None if self.bound is None else list(self.bound),
            "equal_sets_for_accuracy": self.equal_for,
        }


def find_sets(
    bending: Bending,
    reading: Reading | None = None,
    sets: int | None = None,
    centres: Sequence[float] | None = None,
    accuracy: float = ACCURACY,
) -> Sets:
    """The sets: from ``centres``, a number of ``sets``, a ``reading`` of (10), or as printed.

    Raises:
        ValueRefused: more than one of the three, a reading without curvatures or without the name of one, a number
            out of range, or centres that do not rise and lie symmetrically about zero.
    """
    asked = [n for n, v in (("reading", reading), ("sets", sets), ("centres", centres)) if v is not None]
    if len(asked) > 1:
        raise ValueRefused(f"{' and '.join(asked)} are given: the sets can come from one of them alone")
    if not accuracy > 0.0:
        raise ValueRefused(f"accuracy = {accuracy!r}: must be above 0")
    curvatures = bending.values
    if reading is not None and curvatures is None:
        raise ValueRefused(
            f"reading = {reading!r}: equation (10) needs curvatures, and the log carries none: give them (curvature), "
            "or the number of sets"
        )
    count = None if curvatures is None else partition_count(curvatures, accuracy)
    found, source = _found(count, reading, sets, centres)
    flat = curvatures is None or not sum(curvatures) > 0.0
    bound = None if curvatures is None else tuple(interpolation_bound(curvatures, found.centres))
    needed = None if curvatures is None else 2 if flat else equal_sets_for(curvatures, accuracy)
    return Sets(found, source, accuracy, count, reading, bound, needed)


def _found(
    count: PartitionCount | None, reading: Reading | None, sets: int | None, centres: Sequence[float] | None
) -> tuple[Partition, str]:
    if reading is not None:
        assert count is not None
        value = count.under(reading)
        number = count.sets_of_intervals if reading == "intervals" else value
        return even(-1.0, 1.0, _within(number, f"reading {reading!r}")), f"evenly spaced, from (10) read as {reading}"
    if sets is not None:
        return even(-1.0, 1.0, _within(sets, "sets")), "evenly spaced, as many as asked for"
    if centres is None:
        return partition(CENTRES.tolist()), "the paper's printed centres, which follow from no count"
    c = [float(x) for x in centres]
    if len(c) < 2 or any(abs(a + b) > 1e-9 for a, b in zip(c, reversed(c), strict=True)) or abs(c[-1] - 1.0) > 1e-9:
        raise ValueRefused(
            f"centres = {', '.join(f'{x:g}' for x in c)}: expected two or more from -1 to 1, symmetric about 0"
        )
    return partition(c), "as given"


def _within(number: int, what: str) -> int:
    if not 2 <= number <= MOST_SETS:
        raise ValueRefused(f"{what} asks for {number} sets: allowed are 2 to {MOST_SETS}")
    return number
