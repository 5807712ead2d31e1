"""Why a fuzzy system gives what it gives: the rules that fire at a point, how strongly, and their share of each output.

The share of a rule in an output is

- for a weighted defuzzifier its degree over the sum of all degrees: what its value counts in the mean;
- for an integral one its part of the area of the aggregated set: under the maximum each point of the universe belongs
  to the rule whose set is uppermost there (to several in equal parts), under other norms to all rules in the ratio of
  their memberships there.

The shares of an output sum to one.

How strongly each rule fires at many points, and how a recorded run used the rules.

The strength is that of :func:`explain`: the degree of the antecedent, with the rule's weight,
after the activation of its block.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from leadscrew.fuzzy import norms
from leadscrew.fuzzy.engine import Engine, engine, execute
from leadscrew.fuzzy.evaluate import RANKS, plan_views
from leadscrew.fuzzy.rules_text import rule_text
from leadscrew.fuzzy.shapes import membership_function
from leadscrew.fuzzy.system import INTEGRAL, Output, System
from leadscrew.fuzzy.tables import nodes
from leadscrew.fuzzy.writer import Lines
from leadscrew.kernel.engines import native
from leadscrew.kernel.module import Module
from leadscrew.kernel.parameters import nearest
from leadscrew.util.errors import NameUnknown, ValueRefused


@dataclass(frozen=True)
class Share:
    """What a rule that fires does to one output."""

    output: str
    term: str
    degree: float
    """The rule's degree under the hedges of this consequent."""
    part: float
    """Its share of the output, 0 to 1; NaN where an output has no area."""
    value: float
    """What the term stands for in a weighted defuzzifier; NaN for an integral one."""


@dataclass(frozen=True)
class Fired:
    """A rule that fires."""

    number: int
    """Its place among all rules of the system, from 1."""
    text: str
    strength: float
    """The degree of its antecedent, with the rule's weight, after the activation of its block."""
    memberships: dict[str, float]
    """Of each proposition of the antecedent."""
    shares: tuple[Share, ...]


@dataclass(frozen=True)
class Explanation:
    """A system at a point; prints as words."""

    system: str
    inputs: dict[str, float]
    outputs: dict[str, float]
    rules: tuple[Fired, ...]
    """The rules that fire, the strongest first."""
    total: int
    """How many rules the system has."""

    def as_dict(self) -> dict[str, Any]:
        """The same as plain data."""
        from dataclasses import asdict

        return asdict(self)

    def __str__(self) -> str:
        def numbers(values: Mapping[str, float]) -> str:
            return ", ".join(f"{k} = {v:.6g}" for k, v in values.items())

        lines = [f"{numbers(self.outputs)} at {numbers(self.inputs)}"]
        if not self.rules:
            return f"{lines[0]}\nNo rule of {self.total} fires."
        lines.append(f"{len(self.rules)} of {self.total} rules fire{'s' if len(self.rules) == 1 else ''}:")
        for rule in self.rules:
            lines.append(f"  rule {rule.number}, strength {rule.strength:.4f}: {rule.text}")
            lines.append(f"    because {numbers(rule.memberships)}".replace(" = ", ": "))
            for share in rule.shares:
                worth = "" if math.isnan(share.value) else f" ({share.value:.6g})"
                part = "no area" if math.isnan(share.part) else f"{100.0 * share.part:.1f} %"
                lines.append(f"    {part} of {share.output}, by {share.term}{worth}")
        return "\n".join(lines)


def _values(system: System, inputs: Mapping[str, float]) -> list[float]:
    names = [v.name for v in system.inputs]
    for name in inputs:
        if name not in names:
            raise NameUnknown(f"system {system.name} has no input {name!r}{nearest(name, names)}")
    missing = [n for n in names if n not in inputs]
    if missing:
        raise ValueRefused(f"system {system.name}: no value for the input {', '.join(missing)}")
    return [float(inputs[n]) for n in names]


def _parts(output: Output, shares: list[tuple[str, str | None, float]]) -> list[float]:
    """The share of each of an output's rules: term, implication, degree."""
    if not shares:
        return []
    degrees = np.array([d for _, _, d in shares])
    if output.defuzzifier not in INTEGRAL:
        return list(degrees / degrees.sum()) if degrees.sum() > 0.0 else [math.nan] * len(shares)
    xs = nodes(output).tolist()
    sets = {t: [membership_function(output.term(t))(x) for x in xs] for t in {t for t, _, _ in shares}}
    implied: Callable[[str, str | None, float], list[float]] = lambda t, how, d: [  # noqa: E731
        norms.T[str(how)](mu, d) for mu in sets[t]
    ]
    rows = np.array([implied(*share) for share in shares])
    if output.aggregation == "maximum":
        top = rows.max(axis=0)
        owners = (rows == top) & (top > 0.0)
        rows = owners * (top / np.maximum(owners.sum(axis=0), 1))
    total = rows.sum()
    return list(rows.sum(axis=1) / total) if total > 0.0 else [math.nan] * len(shares)


def explain(system: System | Engine, inputs: Mapping[str, float]) -> Explanation:
    """The rules that fire at a point, and what they do to the outputs.

    Raises:
        NameUnknown: no such input.
        ValueRefused: an input without a value, or a system that cannot be evaluated.
    """
    made = system if isinstance(system, Engine) else engine(system)
    whole = made.system
    values = [np.float64(v) for v in _values(whole, inputs)]
    with np.errstate(all="ignore"):
        strengths, spoken = made.space["firing"](made.plan, *values)
        given = made.infer(made.plan, *values, *[math.nan] * len(made.locked))
        found = given if isinstance(given, tuple) else (given,)
        asked = {p: float(made.space["asked"](made.plan, *values)[i]) for i, p in enumerate(made.circuit.props)}
    shares: dict[int, list[Share]] = {i: [] for i in range(len(strengths))}
    place = 0
    for output in made.writer.live:
        mine = made.circuit.shares[output.name]
        said = spoken[place : place + len(mine)]
        place += len(mine)
        acting = [i for i, s in enumerate(mine) if strengths[s.firing] > 0.0]
        parts = _parts(output, [(mine[i].term, mine[i].implication, float(said[i][0])) for i in acting])
        for i, part in zip(acting, parts, strict=True):
            degree, value = (float(x) for x in said[i])
            shares[mine[i].firing].append(Share(output.name, mine[i].term, degree, float(part), value))
    fired = []
    for i, firing in enumerate(made.circuit.firings):
        if strengths[i] > 0.0:
            wanted = list(firing.rule.propositions())
            said_of = {
                f"{p.variable} is {' '.join((*p.hedges, p.term)).strip()}": asked[made.circuit.proposition(p)]
                for p in wanted
            }
            text = rule_text(firing.rule, str)
            fired.append(Fired(firing.number + 1, text, float(strengths[i]), said_of, tuple(shares[i])))
    fired.sort(key=lambda f: -f.strength)
    return Explanation(
        whole.name,
        {v.name: float(x) for v, x in zip(whole.inputs, values, strict=True)},
        {o.name: float(y) for o, y in zip(whole.outputs, found, strict=True)},
        tuple(fired),
        len(whole.rules),
    )


@dataclass(frozen=True)
class Use:
    """How a run used one rule."""

    number: int
    """Its place among all rules of the system, from 1."""
    text: str
    seconds: float
    """How long it fired."""
    part: float
    """That over the length of the run."""
    mean: float
    """Its mean strength while it fired; NaN where it never did."""
    strongest: float
    at: float
    """When it was strongest; NaN where it never fired."""
    enabled: bool = True


def activity(system: System | Engine, points: Any) -> np.ndarray:
    """The strength of every rule at every point: one row a point, one column a rule of the system.

    ``points`` holds one row a point and one column an input. A rule or block that is disabled has zeros.

    Raises:
        ValueRefused: points of another shape, or a system that cannot be evaluated.
    """
    made = system if isinstance(system, Engine) else engine(system)
    names = [v.name for v in made.system.inputs]
    rows = np.asarray(points, dtype=float)
    if rows.ndim != 2 or rows.shape[1] != len(names):
        raise ValueRefused(f"points of shape {rows.shape}: expected one row a point and the columns {', '.join(names)}")
    module = Module()
    functions = execute(_text(made), f"{made.system.name} activity", {**made.space, "Plan": made.plan_type})
    module.function(functions["fires"], trusted=False)
    module.entry(functions["activity"], "activity")
    entry = native(module, "activity", "llvm", f"fuzzy_{module.identity()}_activity", RANKS)
    strengths = np.zeros((len(made.system.rules), len(rows)))
    plan = np.concatenate([np.ravel(a) for a in made.plan])
    entry(plan, np.ascontiguousarray(rows.T), strengths, np.array([0, len(rows)]))
    return strengths.T


def _text(made: Engine) -> str:
    """Source of the strengths at a point, and of the entry that goes through the points."""
    writer, to = made.writer, Lines()
    writer.clipped(to)
    rules = writer.rules(to)
    names = [f"s{i}" for i in range(len(rules))]
    lines = [f"def fires({', '.join(['p', *writer.inputs])}):", '    """Strengths of the rules."""', *to.lines]
    lines += [
        f"    return {', '.join(rules) or '0.0'}",
        "",
        "",
        "def activity(A, X, Y, span):",
        plan_views("A", 0, made),
    ]
    point = ", ".join(["p", *(f"X[{i}, k]" for i in range(len(writer.inputs)))])
    lines += ["    for k in range(span[0], span[1]):", f"        {', '.join(names) or 's0'} = fires({point})"]
    lines += [f"        Y[{f.number}, k] = {n}" for f, n in zip(made.circuit.firings, names, strict=True)]
    return "\n".join([*lines, "    return 0"]) + "\n"


def usage(system: System, time: Any, strengths: np.ndarray) -> tuple[Use, ...]:
    """How a run used each rule, in the order of the system; ``strengths`` as :func:`activity` gives them.

    A row lasts until the next one, the last row as long as the one before it.

    Raises:
        ValueRefused: times that do not rise, or not one for each row of strengths.
    """
    t = rising(time, len(strengths))
    lasts = np.diff(t, append=2.0 * t[-1] - t[-2]) if len(t) > 1 else np.ones(len(t))
    whole = float(lasts.sum())
    found = []
    for i, (rule, on) in enumerate(_rules(system)):
        w = np.nan_to_num(strengths[:, i], nan=0.0)
        firing = w > 0.0
        seconds = float(lasts[firing].sum())
        mean = float((w * lasts)[firing].sum()) / seconds if seconds else math.nan
        at = float(t[np.argmax(w)]) if seconds else math.nan
        strongest = float(w.max(initial=0.0))
        part = seconds / whole if whole else 0.0
        found.append(Use(i + 1, rule_text(rule, str), seconds, part, mean, strongest, at, on))
    return tuple(found)


def rising(time: Any, count: int) -> np.ndarray:
    """Times as an array.

    Raises:
        ValueRefused: they do not rise, or there are not ``count``.
    """
    t = np.asarray(time, dtype=float)
    if t.shape != (count,):
        raise ValueRefused(f"times of shape {t.shape}: expected one for each of {count} points")
    if not np.isfinite(t).all() or not (np.diff(t) > 0.0).all():
        at = int(np.argmin(np.isfinite(t))) if not np.isfinite(t).all() else int(np.argmin(np.diff(t) > 0.0)) + 1
        raise ValueRefused(f"the time of row {at + 1} ({t[at]:g}) does not rise above the one before it")
    return t


def _rules(system: System) -> list[tuple[Any, bool]]:
    """Every rule and whether it and its block are enabled."""
    return [(rule, rule.enabled and block.enabled) for block in system.blocks for rule in block.rules]
