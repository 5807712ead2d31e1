"""What decides the text of a loop's module, and what every part of the linker shares."""

from __future__ import annotations

import ast
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from leadscrew.kernel.block import Block
from leadscrew.kernel.frame import SLOTS, pairs
from leadscrew.kernel.layout import Branch, Layout, Leaf, leaves
from leadscrew.kernel.module import Module
from leadscrew.kernel.syntax import call

LARGEST = 1.7976931348623157e308
LIMITS: dict[str, float | int] = {"float": LARGEST, "int": 2**53 - 1}
"""Of the numbers of a state, by kind; a whole one is kept from period to period as a double."""
LANES = 16
TAIL = ("reference", "disturbance", "output_disturbance", "sensor", "controller", "actuator")
"""Slots whose state the sampling stage writes."""


@dataclass
class Plan:
    """All that decides the text of a module: blocks, types, options, no values."""

    blocks: dict[str, Block | None]
    metrics: dict[str, Block]
    params: Layout
    state: Layout
    signals: dict[str, Any]
    """Example of each signal: ``command, feedback, output, applied, actual, load``; floats or NamedTuples."""
    method: str
    sent: tuple[int, int] = (0, 0)
    """Computational delay: whole periods and further substeps."""
    seen: int = 0
    """Transport delay in substeps."""
    continuous: bool = False
    rtol: float = 1e-6
    atol: float = 1e-9
    columns: list[str] = field(default_factory=list)
    """What can be recorded, in order; filled by the linker."""

    def layout(self) -> tuple[Any, ...]:
        """Where every value lies, and the types that hold them."""
        signals = {k: Layout(v).tree for k, v in self.signals.items()}
        return self.params.tree, self.state.tree, signals


def body_of(node: Leaf | Branch, module: Module, leaf: Callable[[Leaf], ast.expr]) -> ast.expr:
    """Syntax that builds a value, with an expression for every leaf."""
    if isinstance(node, Leaf):
        return leaf(node)
    return call(module.named_tuple(node.type), *(body_of(p, module, leaf) for p in node.parts))


def scalar_leaves(node: Leaf | Branch) -> list[Leaf]:
    """The leaves that are numbers."""
    return [x for x in leaves(node) if x.kind != "array"]


def is_absent(leaf: Leaf) -> bool:
    """Whether a leaf of the state only holds the place of a block without state."""
    return leaf.kind != "array" and leaf.key in (*SLOTS, "metrics", "sent", "seen")


class Linking:
    """Writes small functions and links them to the holes of the drivers."""

    def __init__(self, plan: Plan, module: Module) -> None:
        self.plan = plan
        self.module = module
        self.module.constants.update(RTOL=plan.rtol, ATOL=plan.atol, TIMED=False, LANES=LANES)
        self.state_parts = {p.key: p for p in self._parts(plan.state.tree)}
        self.trees = {k: Layout(v).tree for k, v in plan.signals.items()}
        self.actual_pairs = pairs(self.trees["command"], self.trees["actual"])
        self.feedback_pairs = pairs(self.trees["command"], self.trees["feedback"])

    @staticmethod
    def _parts(tree: Leaf | Branch) -> tuple[Leaf | Branch, ...]:
        return tree.parts if isinstance(tree, Branch) else ()

    def define(self, hole: Callable[..., Any], args: str, body: list[ast.stmt]) -> None:
        """Adds a function and links it to a hole."""
        self.module.link(hole, self.module.generated(hole.__name__, args.split(), body))
