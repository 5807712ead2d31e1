"""The rules of a fuzzy force controller for people: which are active at a point, and the whole as a fuzzy system."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from leadscrew.controllers._grey_fuzzy.rule_tables import MOST, SETS
from leadscrew.controllers._grey_fuzzy.surface import CENTRES, Surface, firing, ready_surface
from leadscrew.util.errors import BlockError

if TYPE_CHECKING:
    from leadscrew.fuzzy.system import System
    from leadscrew.kernel.block import Block

NORMS = ("algebraic_product", "minimum")
"""What joins the two antecedents, by the block's ``inference``."""


@dataclass(frozen=True)
class ActiveRule:
    """A rule that is active, and what it adds to the output."""

    error: str
    """Set of the error, NB to PB."""
    change: str
    """Set of its change."""
    consequent: str
    """Set of the output; two names with ``..`` between them where the table's entry lies between two."""
    share: float
    """Its weight over the sum of all weights; the shares sum to one."""
    value: float
    """What the rule concludes, V."""

    def __str__(self) -> str:
        return (
            f"if e is {self.error} and ec is {self.change} then u is {self.consequent}: "
            f"{self.share:.2f} of {1e3 * self.value:+.2f} mV"
        )


def surface_of(block: Block) -> Surface:
    """The scaling factors and rules of a fuzzy controller of this package.

    Raises:
        BlockError: the block has none.
    """
    fields = getattr(block.params, "_fields", ())
    if not {"error_scale", "change_scale", "output_scale", "rules", "inference"} <= set(fields):
        raise BlockError(
            f"{block.name}: has no rules with scaling factors; tfc, gpfc and what is made of them have (parameters "
            "error_scale, change_scale, output_scale, rules, inference)"
        )
    return ready_surface(block.params)


def set_name(index: float) -> str:
    """The name of a consequent: NB at -3 to PB at 3, and for a number between two sets both, as ``ZO..PS``."""
    low = int(index // 1)
    return SETS[low + MOST] if index == low else f"{SETS[low + MOST]}..{SETS[low + MOST + 1]}"


def active_rules(block: Block, error: float, change: float) -> tuple[ActiveRule, ...]:
    """The rules that are active at an error (N) and a change of it in one period (N), the largest share first.

    For a GPFC these are the predicted error and change: the fields ``error`` and ``change`` of its state.

    Raises:
        BlockError: the block has no such rules.
    """
    p = surface_of(block)
    f = firing(p, error, change)
    found = []
    for row, column, share in (
        (f.row, f.column, f.low_low), (f.row, f.column + 1, f.low_high),
        (f.row + 1, f.column, f.high_low), (f.row + 1, f.column + 1, f.high_high),
    ):  # fmt: skip
        concludes = float(p.rules.table[row, column])
        if share > 0.0:
            value = p.output_scale * concludes
            found.append(ActiveRule(SETS[row], SETS[column], set_name(concludes / 2.0), float(share), value))
    return tuple(sorted(found, key=lambda rule: -rule.share))


def as_fuzzy_system(block: Block) -> System:
    """The rules as a fuzzy system: inputs ``e`` and ``ec`` in N, output ``u`` in V, 7 sets each and 49 rules.

    Sets in units of the signals, ramps at the ends; the weighted mean of the consequents (height defuzzification). What
    it gives is what the rules say: the increment of an incremental controller, before the output's limits.

    Raises:
        BlockError: the block has no such rules.
    """
    from leadscrew.fuzzy.build import constants, takagi_sugeno
    from leadscrew.fuzzy.partition import Partition
    from leadscrew.fuzzy.system import And, Is, Output, Rule

    p = surface_of(block)
    e = Partition(tuple((CENTRES * block.params.error_scale).tolist()), SETS)
    ec = Partition(tuple((CENTRES * block.params.change_scale).tolist()), SETS)
    entries = sorted({float(x) for x in p.rules.table.ravel()} | {float(c) for c in CENTRES})
    names = {x: set_name(x / 2.0) for x in entries}
    names = {x: n if ".." not in n else f"{n.replace('..', '_')}_{k}" for k, (x, n) in enumerate(names.items())}
    most = 2.0 * MOST * p.output_scale
    output = Output("u", -most, most, constants({names[x]: p.output_scale * x for x in entries}), unit="V")
    rules = [
        Rule(And(Is("e", row), Is("ec", column)), (Is("u", names[float(p.rules.table[i, j])]),))
        for i, row in enumerate(SETS)
        for j, column in enumerate(SETS)
    ]
    return takagi_sugeno(
        block.name, [e.as_input("e", "N", "error"), ec.as_input("ec", "N", "change of the error in one period")],
        output, rules, conjunction=NORMS[p.inference], doc=block.doc,
    )  # fmt: skip
