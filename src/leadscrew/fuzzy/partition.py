"""Triangular partitions of unity: sets with their peaks at given centres, feet at the neighbouring centres.

    mu_i(x) = max(0, min((x - c_(i-1)) / (c_i - c_(i-1)), (c_(i+1) - x) / (c_(i+1) - c_i)))

The first and the last set are shouldered: outside the universe ``[c_1, c_n]`` an input counts as its nearest end.
At every ``x`` at most two sets have a membership above zero and the two sum to one, so an input is told by the
interval that it lies in and by its membership in the interval's upper set.

:class:`Partition` is for design and reports (labels, all memberships, ties); :class:`leadscrew.fuzzy.inference.Axis` is
the same partition as a step reads it. A partition becomes the input of a :class:`~leadscrew.fuzzy.system.System` by
:meth:`Partition.as_input`, and comes back by :meth:`Partition.from_input`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from leadscrew.fuzzy.inference import axis
from leadscrew.fuzzy.system import Input, Output, Term
from leadscrew.util.errors import ValueRefused

TIE = 1e-12
"""Two memberships closer than this are a tie: far above rounding, far below three printed digits."""


@dataclass(frozen=True)
class Winner:
    """The set to which a value belongs most."""

    index: int
    membership: float
    tied: bool
    """Another set has the same membership; ``index`` is then the lower of the two."""


@dataclass(frozen=True)
class Winners:
    """The sets to which many values belong most: one entry a value."""

    index: np.ndarray
    membership: np.ndarray
    tied: np.ndarray


@dataclass(frozen=True)
class Partition:
    """A triangular partition of unity with names for its sets."""

    centres: tuple[float, ...]
    labels: tuple[str, ...]

    def __post_init__(self) -> None:
        axis(self.centres)
        if len(self.labels) != len(self.centres):
            raise ValueRefused(f"{len(self.labels)} labels for {len(self.centres)} centres")

    def __len__(self) -> int:
        return len(self.centres)

    def memberships(self, x) -> np.ndarray:
        """Memberships of ``x`` in all sets; one row a value where ``x`` is an array."""
        peaks = np.eye(len(self.centres))
        values = np.asarray(x, dtype=float)
        columns = [np.interp(values, self.centres, peak) for peak in peaks]
        return np.stack(columns, axis=-1)

    def winner(self, x: float) -> Winner:
        """The set of largest membership, and whether it is tied."""
        found = self.winners([x])
        return Winner(int(found.index[0]), float(found.membership[0]), bool(found.tied[0]))

    def winners(self, x) -> Winners:
        """The same of many values at once, in one row."""
        mu = self.memberships(x)
        best = mu > mu.max(axis=-1, keepdims=True) - TIE
        index = np.argmax(best, axis=-1)
        return Winners(index, np.take_along_axis(mu, index[..., None], axis=-1)[..., 0], best.sum(axis=-1) > 1)

    def contracted(self, factor: float) -> Partition:
        """The same sets on a universe scaled by ``factor``."""
        return Partition(tuple(factor * c for c in self.centres), self.labels)

    @property
    def widths(self) -> tuple[float, ...]:
        """Distances between neighbouring centres."""
        return tuple(np.diff(self.centres).tolist())

    # ---- as variables of a system
    def terms(self) -> tuple[Term, ...]:
        """The sets as terms: ramps at the two ends, which hold outside the universe, triangles between."""
        c = [float(x) for x in self.centres]
        ends = (Term(self.labels[0], "ramp", (c[1], c[0])), Term(self.labels[-1], "ramp", (c[-2], c[-1])))
        inner = [Term(n, "triangle", (c[i], c[i + 1], c[i + 2])) for i, n in enumerate(self.labels[1:-1])]
        return (ends[0], *inner, ends[1])

    def as_input(self, name: str, unit: str = "", doc: str = "") -> Input:
        """An input of a system with these sets; its universe runs from the first to the last centre.

        Raises:
            ValueRefused: two sets have the same label.
        """
        return Input(name, float(self.centres[0]), float(self.centres[-1]), self.terms(), unit, doc)

    def as_output(self, name: str, unit: str = "", doc: str = "", default: float = float("nan")) -> Output:
        """An output whose rules conclude the centres (zero-order Takagi-Sugeno), put together as their weighted mean.

        Raises:
            ValueRefused: two sets have the same label.
        """
        terms = tuple(Term(n, "constant", (float(c),)) for n, c in zip(self.labels, self.centres, strict=True))
        return Output(
            name, float(self.centres[0]), float(self.centres[-1]), terms, unit, doc,
            aggregation=None, defuzzifier="weighted_average", default=default,
        )  # fmt: skip

    @classmethod
    def from_input(cls, variable: Input) -> Partition:
        """The partition that an input's terms are.

        Raises:
            ValueRefused: they are none (triangles that sum to one, a shoulder at each end); says so.
        """
        from leadscrew.fuzzy.inference import axis_numbers, is_pointed
        from leadscrew.fuzzy.tables import cuts

        sides = cuts(list(variable.terms))
        if sides is None or not is_pointed(sides):
            raise ValueRefused(f"input {variable.name}: its terms are not triangles, in order, that sum to one")
        centres, _, feet = axis_numbers(sides)
        held = variable.lock_range and (variable.low, variable.high) == (centres[0], centres[-1])
        if not (held or np.isnan(feet).all()):
            raise ValueRefused(
                f"input {variable.name}: its outer sets fall to zero outside the universe; a partition has shoulders "
                "there (ramps, or lock_range on the universe from the first to the last peak)"
            )
        return cls(tuple(centres.tolist()), tuple(t.name for t in variable.terms))
