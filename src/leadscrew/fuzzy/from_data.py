"""From logged data to a fuzzy system in one call: universes, partitions, rules, completion, system, scores.

1. some samples are held out, by a seed; all that follows sees only the others. Neighbours in a log are alike, so this
   flatters: score a move of its own with :func:`score` where there is one;
2. universes: the range of each variable, between two percentiles;
3. partitions (:mod:`leadscrew.fuzzy.grids`): even, by quantiles, or by curvature and accuracy;
4. rules (:mod:`leadscrew.fuzzy.learning`);
5. completion by the named steps (:mod:`leadscrew.fuzzy.fill`), none unless asked for;
6. the system (:func:`to_system`);
7. scores: root mean square and largest error on the samples learned from and on those held out.

Every choice, given or by default, is in :attr:`Learned.choices`.

Learned rules as a system: triangular partitions with shoulders, the product, the mean of the output's centres.

    y = sum_r w_r D_r c_r / sum_r w_r D_r,    D_r = product of the memberships of rule r

with ``c_r`` the centre of the set that the rule concludes and ``w_r = 1``, or the strength of the rule. Outside a
universe an input counts as its end. Where every cell has a rule, all weights are 1 and there are up to three inputs,
only the rules around the point are evaluated (:mod:`leadscrew.fuzzy.inference`). A cell without a rule adds nothing;
where no rule fires the output is ``default``.

Which rules are data and which were filled in stands in :attr:`System.doc` by number, and in :attr:`System.notes` one by
one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from functools import reduce
from typing import Any, Literal

import numpy as np

from leadscrew.fuzzy.curvature import Method
from leadscrew.fuzzy.fill import Completed, complete
from leadscrew.fuzzy.grids import Grid, Reading, even, grid_from_curvature, quantile, universe
from leadscrew.fuzzy.learning import LearnedRules, Ties, finite, learn_rules, runs
from leadscrew.fuzzy.partition import Partition
from leadscrew.fuzzy.rules_text import rule_text
from leadscrew.fuzzy.system import And, Antecedent, Is, Output, Rule, RuleBlock, System
from leadscrew.kernel.parameters import nearest
from leadscrew.util.errors import NameUnknown, ValueRefused


@dataclass(frozen=True)
class Score:
    """Errors of a system on samples, in units of the output."""

    samples: int
    silent: int
    """Samples at which no rule fires (and there is no default): in no error below."""
    rmse: float
    worst: float
    worst_sample: int
    """Number of the sample with the largest error in the data, from 0; -1 where there is none."""
    spread: float
    """Root mean square about the mean: the error of a constant."""

    def sentence(self, what: str) -> str:
        """One line of text; ``what`` says which samples."""
        silent = f"; no rule fires at {self.silent}" if self.silent else ""
        return (
            f"{what}: {self.samples} samples, error rms {self.rmse:.4g}, largest {self.worst:.4g} (sample "
            f"{self.worst_sample}, from 0); a constant would have {self.spread:.4g} rms{silent}"
        )


def score(system: System, rows: np.ndarray, numbers: np.ndarray | None = None) -> Score:
    """Errors of a system of one output on rows ``(inputs, output)``; ``numbers``: what the samples are called.

    Raises:
        ValueRefused: a system of several outputs, no rows, or rows of another length.
    """
    from leadscrew.fuzzy.evaluate import compiled

    if len(system.outputs) != 1 or rows.ndim != 2 or not len(rows) or rows.shape[1] != len(system.inputs) + 1:
        raise ValueRefused(
            f"rows of shape {rows.shape} for {len(system.inputs)} inputs and {len(system.outputs)} outputs"
        )
    error = compiled(system).many(rows[:, :-1]) - rows[:, -1]
    fires = np.isfinite(error)
    spread = float(np.std(rows[:, -1]))
    if not fires.any():
        return Score(len(rows), len(rows), math.nan, math.nan, -1, spread)
    at = int(np.argmax(np.where(fires, np.abs(error), -1.0)))
    rmse, worst = float(np.sqrt(np.mean(error[fires] ** 2))), float(abs(error[at]))
    return Score(len(rows), int((~fires).sum()), rmse, worst, at if numbers is None else int(numbers[at]), spread)


Weights = Literal["none", "strength"]
Conclude = Literal["centres", "sets"]


def to_system(
    rules: LearnedRules | Completed,
    name: str = "learned",
    *,
    units: Mapping[str, str] | None = None,
    weights: Weights = "none",
    conclude: Conclude = "centres",
    default: float = math.nan,
) -> System:
    """The system of learned rules, or of a table after completion.

    ``units``: by the name of a variable. ``weights="strength"`` weighs rules by their strength; a rule that was filled
    in then counts as little as the weakest rule from data. ``conclude="centres"`` makes the consequents constants
    (zero-order Takagi-Sugeno, every format has it); ``"sets"`` keeps them sets, put together by their peaks (height).

    Raises:
        ValueRefused: no rule at all, an unknown choice, or two sets of a variable with the same label.
    """
    for what, value, known in (
        ("weights", weights, ("none", "strength")),
        ("conclude", conclude, ("centres", "sets")),
    ):
        if value not in known:
            raise ValueRefused(f"{what} = {value!r}: allowed are {', '.join(known)}")
    table = rules if isinstance(rules, Completed) else complete(rules)
    learned = table.learned
    if not table.outputs:
        raise ValueRefused("no rule was learned: a system needs at least one")
    unit = dict(units or {})
    *ins, out = learned.names
    inputs = tuple(p.as_input(n, unit.get(n, "")) for n, p in zip(ins, learned.inputs, strict=True))
    made = tuple(_rule(table, at, weights) for at in table.outputs)
    sources = _sources(table, weights)
    return System(
        name, inputs, (_output(learned, out, unit.get(out, ""), conclude, default),),
        (RuleBlock(made, conjunction="algebraic_product", implication=None),),
        f"{len(made)} of {learned.total} rules: {sources}", _notes(table, made),
    )  # fmt: skip


def _rule(table: Completed, at: tuple[int, ...], weights: Weights) -> Rule:
    learned = table.learned
    *ins, out = learned.names
    asked: list[Antecedent] = [Is(n, label) for n, label in zip(ins, learned.labels(at), strict=True)]
    then = (Is(out, learned.output.labels[table.outputs[at]]),)
    if weights == "none":
        return Rule(reduce(And, asked), then)
    strengths = {a: cell.winner.strength for a, cell in learned.cells.items()}
    from_data = table.sources[at] == "data"
    return Rule(reduce(And, asked), then, min(1.0, strengths[at] if from_data else min(strengths.values())))


def _output(learned: LearnedRules, name: str, unit: str, conclude: Conclude, default: float) -> Output:
    made = learned.output.as_output(name, unit, default=default)
    if conclude == "centres":
        return made
    return replace(made, terms=learned.output.terms(), aggregation="maximum", defuzzifier="height")


def _sources(table: Completed, weights: Weights) -> str:
    by_source: dict[str, list[int]] = {}
    for number, at in enumerate(table.outputs, start=1):
        by_source.setdefault(table.sources[at], []).append(number)
    parts = [
        f"{runs(numbers)} {'from data (Wang and Mendel)' if source == 'data' else f'filled by {source}'}"
        for source, numbers in sorted(by_source.items(), key=lambda item: (item[0] != "data", item[0]))
    ]
    weighed = "; weights are strengths, of filled rules the least" if weights == "strength" else ""
    return "; ".join(parts) + weighed


def _notes(table: Completed, made: tuple[Rule, ...]) -> tuple[str, ...]:
    notes = []
    for number, (at, rule) in enumerate(zip(table.outputs, made, strict=True), start=1):
        text = rule_text(rule, str)
        if table.sources[at] == "data":
            cell = table.learned.cells[at]
            said = f"data, strength {cell.winner.strength:.3f}, {cell.winner.count} of {cell.count} samples"
        else:
            said = f"{table.sources[at]}, not data"
        notes.append(f"rule {number} ({text}): {said}")
    if table.missing:
        notes.append(f"{table.missing} cells have no rule")
    return tuple(notes)


@dataclass(frozen=True)
class Choices:
    """What can be chosen in :func:`learn`; the fields' defaults are those of the function."""

    sets: int | Mapping[str, int] = 7
    """Of every variable, or by name (7 where one is not named). A rule concludes a centre of the output: with few sets
    there it is off by up to half their distance, however many sets the inputs have."""
    grid: Literal["even", "quantile", "curvature"] = "even"
    """Of the inputs; the output is always even. ``curvature`` takes their number of sets from equation (10)."""
    accuracy: float | None = None
    reading: Reading | None = None
    """Needed for ``curvature``: in units of the output, and how to read the equation."""
    curvature: Method = "local"
    percentiles: tuple[float, float] = (0.0, 100.0)
    """Of the data, where universes begin and end."""
    symmetric: bool | None = None
    """Universes about zero; None: where completion has a step that needs it (antisymmetric, servo, servo_growth)."""
    ties: Ties = "drop"
    complete: tuple[str, ...] = ()
    directions: Mapping[str, int] | None = None
    weights: str | None = None
    """Name of the data's column with the samples' weights in (0, 1]."""
    rule_weights: Weights = "none"
    conclude: Conclude = "centres"
    hold_out: float = 0.0
    """Part of the samples that is held out, 0 to 0.9."""
    seed: int = 0
    name: str = "learned"
    units: Mapping[str, str] | None = None
    default: float = math.nan
    """The output where no rule fires."""


@dataclass(frozen=True)
class Learned:
    """A system from data, and everything that led to it."""

    system: System
    rules: LearnedRules
    completed: Completed
    grid: Grid | None
    """Where the partitions came from curvature."""
    training: Score
    held_out: Score | None
    choices: Choices

    def report(self, most: int = 30) -> str:
        """The chain as text; lists are cut after ``most`` lines, and say so."""
        parts = [_universes(self.rules), *([self.grid.report()] if self.grid else []), "", self.rules.report(most), ""]
        parts += [self.completed.report(most), f"system {self.system.name}: {self.system.doc}", ""]
        parts.append(self.training.sentence("learned from"))
        if self.held_out:
            parts.append(self.held_out.sentence("held out"))
        return "\n".join(parts)

    def as_dict(self) -> dict[str, Any]:
        """The same as plain data, for JSON."""
        given = {
            "choices": {f.name: _mapped(getattr(self.choices, f.name)) for f in fields(self.choices)},
            "grid": self.grid.as_dict() if self.grid else None,
            "learning": self.rules.as_dict(),
            "completion": self.completed.as_dict(),
            "system": {"name": self.system.name, "rules": len(self.system.rules), "doc": self.system.doc},
            "training": asdict(self.training),
            "held_out": asdict(self.held_out) if self.held_out else None,
        }
        plain: dict[str, Any] = finite(given)
        return plain


def learn(data: Mapping[str, Any], inputs: Sequence[str], output: str, **choices: Any) -> Learned:
    """A system that gives ``output`` from ``inputs``, from columns of data by name; ``choices``: :class:`Choices`.

    Raises:
        NameUnknown: no such column, choice, step or input.
        ValueRefused: columns of different lengths or with values that are not finite (row from 0), a choice out of
            range, or data that a step cannot work with; says why.
    """
    chosen = _choices(choices)
    names = (*inputs, output)
    rows, weights = _columns(data, names, chosen.weights)
    train, held = _split(len(rows), chosen.hold_out, chosen.seed)
    partitions, grid = _partitions(rows[train], names, chosen)
    rules = learn_rules(
        rows[train], partitions[:-1], partitions[-1], chosen.ties, names=names, numbers=train,
        weights=None if weights is None else weights[train],
    )  # fmt: skip
    completed = complete(rules, chosen.complete, chosen.directions)
    system = to_system(
        completed, chosen.name, units=chosen.units, weights=chosen.rule_weights, conclude=chosen.conclude,
        default=chosen.default,
    )  # fmt: skip
    scores = [score(system, rows[part], part) for part in (train, held) if len(part)]
    return Learned(system, rules, completed, grid, scores[0], scores[1] if len(held) else None, chosen)


# ---- steps
def _choices(given: Mapping[str, Any]) -> Choices:
    known = [f.name for f in fields(Choices)]
    for name in given:
        if name not in known:
            raise NameUnknown(f"learn has no choice {name!r}{nearest(name, known)}")
    chosen = Choices(**given)
    if not 0.0 <= chosen.hold_out <= 0.9:
        raise ValueRefused(f"hold_out = {chosen.hold_out!r}: allowed is 0 to 0.9")
    if math.isinf(chosen.default):
        raise ValueRefused(f"default = {chosen.default!r}: allowed is a finite number, or NaN for none")
    if chosen.grid not in ("even", "quantile", "curvature"):
        raise ValueRefused(f"grid = {chosen.grid!r}: allowed are even, quantile, curvature")
    if chosen.grid == "curvature" and (chosen.accuracy is None or chosen.reading is None):
        raise ValueRefused(
            "grid = 'curvature' needs an accuracy and a reading of equation (10): half, full or intervals"
        )
    if chosen.grid != "curvature" and (chosen.accuracy is not None or chosen.reading is not None):
        raise ValueRefused(f"accuracy and reading are for grid = 'curvature', not {chosen.grid!r}")
    steps = tuple(chosen.complete)
    about_zero = bool({"antisymmetric", "servo", "servo_growth"} & set(steps))
    symmetric = about_zero if chosen.symmetric is None else chosen.symmetric
    return Choices(**{**{n: getattr(chosen, n) for n in known}, "complete": steps, "symmetric": symmetric})


def _columns(
    data: Mapping[str, Any], names: tuple[str, ...], weights: str | None
) -> tuple[np.ndarray, np.ndarray | None]:
    if len(names) < 2 or len(set(names)) < len(names):
        raise ValueRefused(f"inputs and output {', '.join(names)}: expected one input at least, and different names")
    wanted = names if weights is None else (*names, weights)
    for name in wanted:
        if name not in data:
            raise NameUnknown(f"the data has no column {name!r}{nearest(name, list(data))}")
    columns = [np.asarray(data[name], dtype=float) for name in wanted]
    if any(c.ndim != 1 or len(c) != len(columns[0]) for c in columns) or not len(columns[0]):
        raise ValueRefused(f"columns {', '.join(wanted)}: expected rows of equal, positive length")
    rows = np.stack(columns, axis=1)
    bad = np.argwhere(~np.isfinite(rows))
    if len(bad):
        row, column = bad[0].tolist()
        raise ValueRefused(f"row {row} (from 0): {wanted[column]} = {rows[row, column]}: must be finite")
    return rows[:, : len(names)], None if weights is None else rows[:, -1]


def _split(samples: int, hold_out: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    order = np.random.default_rng(seed).permutation(samples)
    held = round(hold_out * samples)
    if held >= samples:
        raise ValueRefused(f"hold_out = {hold_out:g} of {samples} samples leaves none to learn from")
    return np.sort(order[held:]), np.sort(order[:held])


def _partitions(rows: np.ndarray, names: tuple[str, ...], chosen: Choices) -> tuple[list[Partition], Grid | None]:
    ranges = [
        universe(column, chosen.percentiles, bool(chosen.symmetric), name)
        for column, name in zip(rows.T, names, strict=True)
    ]
    sets = _sets(chosen.sets, names)
    output = even(*ranges[-1], sets[names[-1]])
    if chosen.grid == "curvature":
        assert chosen.accuracy is not None and chosen.reading is not None
        grid = grid_from_curvature(
            rows[:, :-1], rows[:, -1], ranges[:-1], chosen.accuracy, chosen.reading, method=chosen.curvature
        )
        return [*grid.partitions, output], grid
    made = [
        even(*ends, sets[name]) if chosen.grid == "even" else quantile(column, sets[name], *ends)
        for column, name, ends in zip(rows.T, names[:-1], ranges, strict=False)
    ]
    return [*made, output], None


def _sets(sets: int | Mapping[str, int], names: tuple[str, ...]) -> dict[str, int]:
    if not isinstance(sets, Mapping):
        return dict.fromkeys(names, sets)
    for name in sets:
        if name not in names:
            raise NameUnknown(f"sets: there is no variable {name!r}{nearest(name, list(names))}")
    return {**dict.fromkeys(names, 7), **sets}


def _mapped(value: Any) -> Any:
    return dict(value) if isinstance(value, Mapping) else value


# ---- text
def _universes(rules: LearnedRules) -> str:
    lines = []
    for name, p in zip(rules.names, (*rules.inputs, rules.output), strict=True):
        sets = ", ".join(f"{label} {c:.6g}" for label, c in zip(p.labels, p.centres, strict=True))
        lines.append(f"{name}: {len(p)} sets on [{p.centres[0]:.6g}, {p.centres[-1]:.6g}]: {sets}")
    gap, output = max(rules.output.widths), rules.names[-1]
    lines.append(
        f"rules conclude centres of {output}, up to {gap:.4g} apart: off by up to {0.5 * gap:.4g} by that alone"
    )
    return "\n".join(lines)
