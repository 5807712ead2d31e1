"""Steps 2 to 6 of the design of a VUD fuzzy controller: universes, curvature, sets, rules, factors.

**Step 2**: what e = 1 and ec = 1 mean in millimetres.

A measured log gives the universes that it reaches: the largest error and the largest change of the error in any
interval, wherever the interval begins. A normalised log has its universes already; what they are in mm follows from
``r`` and the first ``e`` of the longest move, and from the change of ``e`` that one unit of ``ec`` stands for (least
squares over all moves).

Source: step 1 of section IV.b of Long et al. (2014), equations (5) and (6).

**Step 3**: how strongly the old controller's law bends along e and ec, where the log can tell.

Polynomials of degree 2 and 3 in (e, ec) are fitted to the duty (:mod:`leadscrew.fuzzy.curvature`). A step response is a
curve in the plane of e and ec, not a region, and along a curve the two curvatures cannot be told apart: the condition
number of the fit says so, and a fit above the limit is refused. Of the degrees that pass the highest is taken. The
numbers may be given instead; the paper read 1.96 and 1.35 off a scope, (8) and (9).

**Step 4**: how many sets, and where.

Equation (10) of Long et al. (2014) can be read in three ways (:mod:`leadscrew.fuzzy.grids`), and none is preferred
here: the count is taken from (10) only under a reading that is named, and gives evenly spaced sets. Centres
may be given instead, or a number of sets. With nothing given the paper's printed centres stand, and the step says that
they follow from no count.

Whatever the sets, the error that they guarantee for the curvatures is ``h^2 / 8 (u_ee + u_cc)`` in the widest interval.

**Step 5**: rules from the samples, and the rest of the table by steps that are named.

Rules come by look-up table and strength (:mod:`leadscrew.fuzzy.learning`, equations (11) to (16)); samples exactly
between two sets are left out. The cells that no sample covers are filled by the steps asked for
(:mod:`leadscrew.fuzzy.fill`): with an even number of sets ``servo_growth`` by default, with an odd number
``antisymmetric`` and ``monotone``, both falling with e and ec. A cell without a rule is refused: the controller would
have no duty there.

**Step 6**: the contraction-expansion factors, and which law they go into.

``vud_beta_e``
    the output's factor follows the error, ``output_gain (|e|^output_tau + floor)``: the law of (21) with (19) changed;
``vud``
    as printed: the output's factor follows the last duty, (19), and the axis creeps. For a constant ``shape`` the duty
    falls to ``shape^(1 / (1 - tau))``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np

from leadscrew.controllers._vud.universe import CENTRES, TABLE_2
from leadscrew.design.files import MoveLog
from leadscrew.fuzzy.curvature import estimate_curvature
from leadscrew.fuzzy.fill import Completed, complete
from leadscrew.fuzzy.grids import (
    PartitionCount,
    Reading,
    equal_sets_for,
    even,
    interpolation_bound,
    partition,
    partition_count,
)
from leadscrew.fuzzy.learning import LearnedRules, aligned, learn_rules
from leadscrew.fuzzy.partition import Partition
from leadscrew.util.errors import DataError, ValueRefused

MOST_APART = 0.05
"""Part by which the moves' own scales of e may differ."""


@dataclass(frozen=True)
class Universes:
    """Scales of the inputs, and how far the samples reach into [-1, 1]."""

    error_mm: float
    rate_mm: float
    """Change per interval."""
    interval_s: float
    reached: tuple[float, float]
    """Largest size of e in the log, its starts included, and of ec among the samples."""
    how: tuple[str, str]
    """Where each scale comes from."""
    outside: tuple[int, int] = (0, 0)
    """Samples of e and ec beyond their universe, which a narrower scale leaves; they count as its end."""

    def lines(self) -> list[str]:
        """The step as text."""
        names = ("e", "ec")
        scales = (f"{self.error_mm:.6g} mm", f"{self.rate_mm:.6g} mm per {self.interval_s:g} s")
        lines = [
            f"{name} = 1 is {scale}: {how}; the log reaches {reached:.3f}"
            for name, scale, how, reached in zip(names, scales, self.how, self.reached, strict=True)
        ]
        return lines + [
            f"{count} samples of {name} lie outside and count as the end of their universe"
            for name, count in zip(names, self.outside, strict=True)
            if count
        ]

    def as_dict(self) -> dict[str, Any]:
        """The same as plain data."""
        return asdict(self)


def find_universes(
    log: MoveLog, error_scale_mm: float | None = None, rate_scale_mm: float | None = None
) -> tuple[Universes, np.ndarray]:
    """The universes of a log, and its samples ``(e, ec, duty)`` in them; a scale that is given stands in for the log's.

    Raises:
        ValueRefused: a scale that is not positive.
        DataError: a normalised log whose ``r`` and ``e`` disagree, or do not say what e = 1 is.
    """
    for name, value in (("error_scale", error_scale_mm), ("rate_scale", rate_scale_mm)):
        if value is not None and not (value > 0.0 and np.isfinite(value)):
            raise ValueRefused(f"{name} = {value!r}: must be a number of mm above 0")
    normalised = log.layout == "normalised"
    own = _normalised(log, error_scale_mm) if normalised else _measured(log)
    error = own[0][0] if error_scale_mm is None else error_scale_mm
    rate = own[1][0] if rate_scale_mm is None else rate_scale_mm
    how = (
        own[0][1] if error_scale_mm is None else "given",
        own[1][1] if rate_scale_mm is None else f"given (the log says {own[1][0]:.4g})",
    )
    samples = log.samples() if normalised else log.samples() / [error, rate, 1.0]
    sizes = [np.abs(samples[:, k]) for k in (0, 1)]
    whole = max(float(np.abs(m.error).max()) for m in log.moves)
    reached = (whole if normalised else whole / error, float(sizes[1].max()))
    outside = (int((sizes[0] > 1.0).sum()), int((sizes[1] > 1.0).sum()))
    return Universes(error, rate, log.interval_s, reached, how, outside), samples


def _measured(log: MoveLog) -> tuple[tuple[float, str], tuple[float, str]]:
    error = max(float(np.abs(m.error).max()) for m in log.moves)
    return (error, "the largest error"), (log.peak_change, f"the largest change of the error in {log.interval_s:g} s")


def _normalised(log: MoveLog, error_scale_mm: float | None) -> tuple[tuple[float, str], tuple[float, str]]:
    error, how = (error_scale_mm, "given") if error_scale_mm is not None else _scale_of_r(log)
    factor, rest = log.scale()
    own = ", ".join(f"{abs(error * log.scale((m,))[0]):.2f}" for m in log.moves)
    return (error, how), (
        factor * error,
        f"least squares of the change of e on ec (the moves by themselves: {own}; {100.0 * rest:.1f} % left)",
    )


def _scale_of_r(log: MoveLog) -> tuple[float, str]:
    """``r`` over the first ``e`` of the longest move."""
    where = ", ".join(log.sources)
    found = {
        m.name: float(m.target_mm / m.error[0])
        for m in log.moves
        if m.target_mm and m.number[0] == 0.0 and m.error[0] != 0.0
    }
    if not found:
        raise DataError(f"{where}: no move has a row k = 0 with r and e: say with error_scale what e = 1 is in mm")
    longest = max((m for m in log.moves if m.name in found), key=lambda m: abs(m.error[0]))
    scale = found[longest.name]
    for name, other in found.items():
        if not abs(other - scale) <= MOST_APART * abs(scale) or other <= 0.0:
            raise DataError(
                f"{where}: r over e at k = 0 is {other:.4g} mm in the move {name} and {scale:.4g} mm in "
                f"{longest.name}: columns r and e do not belong together"
            )
    return scale, f"r over e at k = 0 of the move {longest.name}"


DEGREES = (2, 3)
MOST_CONDITION = 30.0
"""Random samples of two inputs give 1 to 20 (:mod:`leadscrew.fuzzy.curvature`)."""


@dataclass(frozen=True)
class Attempt:
    """One fit."""

    degree: int
    condition: float
    """Infinite where the fit has no unique answer, or too few samples."""
    values: tuple[float, ...]
    error: tuple[float, ...]
    """Standard errors of ``values``."""
    said: str
    """Why it is refused; empty where it is not."""


@dataclass(frozen=True)
class Bending:
    """Curvatures u_ee and u_cc on universes scaled to [-1, 1], or why there are none."""

    values: tuple[float, float] | None
    source: Literal["given", "estimated", "refused"]
    attempts: tuple[Attempt, ...]
    most_condition: float = MOST_CONDITION

    def lines(self) -> list[str]:
        """The step as text."""
        lines = [
            f"degree {a.degree}: {a.said}" if a.said else
            f"degree {a.degree}: u_ee {a.values[0]:.3g} +- {a.error[0]:.2g}, u_cc {a.values[1]:.3g} +- "
            f"{a.error[1]:.2g}, condition number {a.condition:.3g}"
            for a in self.attempts
        ]  # fmt: skip
        if self.values is None:
            return [*lines, "no curvature: log moves of several sizes with an added excitation, or give --curvature"]
        return [*lines, f"{self.source}: u_ee {self.values[0]:.4g}, u_cc {self.values[1]:.4g}"]

    def as_dict(self) -> dict[str, Any]:
        """The same as plain data."""
        return asdict(self)


def find_bending(
    samples: np.ndarray, given: Sequence[float] | None = None, most_condition: float = MOST_CONDITION
) -> Bending:
    """The step for samples ``(e, ec, duty)`` on [-1, 1]; ``given`` curvatures are taken, and the fits still shown.

    Raises:
        ValueRefused: other than two given curvatures, or negative ones.
    """
    if given is not None and (len(given) != 2 or not all(0.0 <= c < math.inf for c in given)):
        raise ValueRefused(f"curvature = {', '.join(f'{c:g}' for c in given)}: expected u_ee and u_cc, 0 or more")
    attempts = tuple(_attempt(samples, degree, most_condition) for degree in DEGREES)
    if given is not None:
        return Bending((float(given[0]), float(given[1])), "given", attempts, most_condition)
    passed = [a for a in attempts if not a.said]
    if not passed:
        return Bending(None, "refused", attempts, most_condition)
    return Bending((passed[-1].values[0], passed[-1].values[1]), "estimated", attempts, most_condition)


def _attempt(samples: np.ndarray, degree: int, most_condition: float) -> Attempt:
    try:
        found = estimate_curvature(
            samples[:, :2], samples[:, 2], ((-1.0, 1.0),) * 2, method="polynomial", degree=degree,
            most_condition=math.inf,
        )  # fmt: skip
    except ValueRefused as problem:
        return Attempt(degree, math.inf, (), (), f"refused: {problem}")
    refused = (
        f"refused: condition number {found.condition:.3g}, allowed is {most_condition:g}: the samples do not tell u_ee "
        "from u_cc"
    )
    said = refused if found.condition > most_condition else ""
    return Attempt(degree, found.condition, found.values, found.error, said)


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


NAMES = ("e", "ec", "rho")
EVEN_STEPS = ("servo_growth",)
ODD_STEPS = ("antisymmetric", "monotone")
FALLING = {"e": -1, "ec": -1}
"""The duty of a servo axis falls with the error and with its change."""


@dataclass(frozen=True)
class Compared:
    """A table beside the printed Table 2, by output sets."""

    agree: int
    """Covered cells whose winner is Table 2's."""
    other: tuple[tuple[int, ...], ...]
    """Covered cells with another."""
    equal: int
    """Cells of the completed table that equal Table 2's."""


@dataclass(frozen=True)
class Rules:
    """Learned rules, their completion and the consequents."""

    learned: LearnedRules
    completed: Completed
    steps: tuple[str, ...]
    table: np.ndarray
    """Duty of each rule, rows by e and columns by ec."""
    compared: Compared | None
    """With Table 2, where the table has its size."""

    def lines(self, most: int = 30) -> list[str]:
        """The step as text."""
        lines = self.learned.report(most).splitlines()
        if self.compared is not None:
            names = ", ".join(f"({', '.join(self.learned.labels(at))})" for at in self.compared.other)
            rest = f"; the data disagrees with it in {names}" if names else ""
            lines += [
                "",
                f"{self.compared.agree} of {self.learned.covered} covered cells agree with the printed Table 2{rest}",
            ]
        lines += ["", "completion, which is not data:", *(f"  {x}" for x in self.completed.report(most).splitlines())]
        if self.compared is not None:
            lines.append(f"  {self.compared.equal} of {self.table.size} cells are those of Table 2")
        return [*lines, "", *self._drawn(most)]

    def _drawn(self, most: int) -> list[str]:
        """The completed table, data in brackets."""
        p = self.learned.output
        if len(p) > most:
            return []
        sources = self.completed.sources
        rows = [
            [f"e {label}", *(
                f"[{p.labels[k]}]" if sources[i, j] == "data" else f" {p.labels[k]}"
                for j, k in enumerate(self.completed.outputs[i, j] for j in range(len(p)))
            )]
            for i, label in enumerate(p.labels)
        ]  # fmt: skip
        return ["the table, rules from data in brackets:", *aligned([["", *(f"ec {x}" for x in p.labels)], *rows])]

    def as_dict(self) -> dict[str, Any]:
        """The same as plain data."""
        compared = None if self.compared is None else {
            "agree": self.compared.agree,
            "other": [self.learned.labels(at) for at in self.compared.other],
            "equal_cells": self.compared.equal,
        }  # fmt: skip
        return {
            "learning": self.learned.as_dict(),
            "completion": self.completed.as_dict(),
            "steps": list(self.steps),
            "table": self.table.tolist(),
            "compared_with_table_2": compared,
        }


def find_rules(
    samples: np.ndarray,
    sets: Partition,
    steps: Sequence[str] | None = None,
    levels: Sequence[float] | None = None,
) -> Rules:
    """The table for samples ``(e, ec, duty)``, the same sets on all three universes.

    ``levels``: sizes of the consequents of the positive sets, small to big, in place of the sets' centres (Table 2
    prints 0.333, 0.677, 1 beside centres 0.33, 0.67, 1).

    Raises:
        ValueRefused: no rule is learned, a step that does not fit, levels that do not, or cells left without a rule.
    """
    size = _sizes(sets, levels)
    learned = learn_rules(samples, (sets, sets), sets, names=NAMES)
    chosen = tuple(steps) if steps is not None else EVEN_STEPS if len(sets) % 2 == 0 else ODD_STEPS
    completed = complete(learned, chosen, FALLING)
    if completed.missing:
        done = f"after {', '.join(chosen)}" if chosen else "without a step of completion"
        raise ValueRefused(
            f"{completed.missing} of {learned.total} cells have no rule {done}, and the controller would have no duty "
            "there: log more moves, take fewer sets, or add the step nearest"
        )
    index = np.zeros(learned.shape, dtype=int)
    for at, output in completed.outputs.items():
        index[at] = output
    return Rules(learned, completed, chosen, size[index], _compared(learned, index))


def _sizes(sets: Partition, levels: Sequence[float] | None) -> np.ndarray:
    """The consequent of each output set."""
    c = np.array(sets.centres)
    if levels is None:
        return c
    positive = int((c > 0.0).sum())
    given = np.array([float(x) for x in levels])
    if len(given) != positive or not (np.diff(given) > 0.0).all() or not 0.0 < given[0] <= given[-1] <= 1.0:
        raise ValueRefused(
            f"levels = {', '.join(f'{x:g}' for x in given)}: expected {positive} rising numbers above 0 up to 1"
        )
    middle = [0.0] * (len(c) - 2 * positive)
    return np.array([*(-given[::-1]), *middle, *given])


def _compared(learned: LearnedRules, index: np.ndarray) -> Compared | None:
    if index.shape != TABLE_2.shape:
        return None
    agree, other = learned.agreement(TABLE_2)
    order = np.unique(TABLE_2)
    printed = np.searchsorted(order, TABLE_2)
    return Compared(agree, tuple(other), int((index == printed).sum()))


Law = Literal["vud_beta_e", "vud"]
LAWS: tuple[Law, ...] = ("vud_beta_e", "vud")


@dataclass(frozen=True)
class Factors:
    """Exponents and floor of (17) to (19), and the law."""

    law: Law = "vud_beta_e"
    tau: float = 0.9
    floor: float = 1e-4
    output_tau: float = 0.6
    output_gain: float = 1.5

    def __post_init__(self) -> None:
        if self.law not in LAWS:
            raise ValueRefused(f"law = {self.law!r}: allowed are {', '.join(LAWS)}")
        for name, low, high in (("tau", 0.0, 2.0), ("output_tau", 0.0, 2.0)):
            if not low <= getattr(self, name) <= high:
                raise ValueRefused(f"{name} = {getattr(self, name)!r}: allowed are {low:g} to {high:g}")
        if not 0.0 < self.floor <= 1.0:
            raise ValueRefused(f"floor = {self.floor!r}: allowed is above 0 to 1")
        if not 0.0 < self.output_gain < float("inf"):
            raise ValueRefused(f"output_gain = {self.output_gain!r}: must be above 0")

    def parameters(self) -> dict[str, float]:
        """Of the controller's block."""
        found = {"tau": self.tau, "floor": self.floor}
        if self.law == "vud_beta_e":
            found |= {"output_tau": self.output_tau, "output_gain": self.output_gain}
        return found

    def lines(self) -> list[str]:
        """The step as text."""
        inputs = f"alpha(x) = |x|^{self.tau:g} + {self.floor:g} for x = e and ec, 1 in the first period (17), (18)"
        if self.law == "vud":
            power = f", a power of {1.0 / (1.0 - self.tau):.3g}," if self.tau < 1.0 else ""
            return [
                inputs,
                f"beta = |duty|^{self.tau:g} + {self.floor:g} as printed (19), as asked: the duty is made from the "
                f"last one{power} and the axis creeps",
            ]
        return [
            inputs,
            f"beta = {self.output_gain:g} (|e|^{self.output_tau:g} + {self.floor:g}) in place of (19): the printed "
            "factor follows the last duty and makes the axis creep (--law vud writes it all the same)",
        ]

    def as_dict(self) -> dict[str, Any]:
        """The same as plain data."""
        return asdict(self)
