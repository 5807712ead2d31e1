"""How strongly each rule fires at many points, and how a recorded run used the rules.

The strength is that of :func:`leadscrew.fuzzy.explain.explain`: the degree of the antecedent, with the rule's weight,
after the activation of its block.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from leadscrew.fuzzy.engine import Engine, engine, execute
from leadscrew.fuzzy.entries import plan_views
from leadscrew.fuzzy.evaluate import RANKS
from leadscrew.fuzzy.rules_text import rule_text
from leadscrew.fuzzy.system import System
from leadscrew.fuzzy.text import Lines
from leadscrew.kernel.engines import native
from leadscrew.kernel.errors import ValueRefused
from leadscrew.kernel.module import Module


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
