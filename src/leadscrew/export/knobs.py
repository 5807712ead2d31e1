"""Which parameters can be changed on the machine: the ones that reach the step unchanged.

A block that prepares its parameters (works out filter coefficients, tables) hands its step other numbers than those of
the data sheet. A parameter is a knob where changing it changes nothing but copies of itself; else it is baked in.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any

from leadscrew.escape import c_comment
from leadscrew.export.core import Knob
from leadscrew.kernel.block import Block
from leadscrew.kernel.c99.names import safe, safe_field
from leadscrew.kernel.errors import LeadscrewError
from leadscrew.kernel.layout import Layout, numbers_of
from leadscrew.kernel.sheet import Entry, entries, put


def _others(entry: Entry) -> Iterator[Any]:
    """Other values that a parameter may have, near its own."""
    value = entry.stored(entry.default)
    if entry.choice is not None:
        yield from (number for number in range(len(entry.choice.names)) if number != value)
        return
    if entry.type == "bool":
        yield not value
        return
    steps = (1, -1, 2, -2) if entry.type == "int" else (0.01, -0.01, 1e-3, -1e-3, 1e-6, -1e-6)
    scale = 1 if entry.type == "int" else max(abs(value), 1e-3)
    for step in steps:
        try:
            yield entry.check(value + step * scale)
        except LeadscrewError:
            continue


def _prepared(block: Block, params: Any, period: float) -> list[float]:
    made = params if block.prepare is None else block.prepare(params, period)
    return list(numbers_of(made))


def _places(prepared: Any) -> list[str]:
    """The C place of every number of the prepared parameters, in their order; empty for elements of arrays."""
    found: list[str] = []
    for leaf in _in_order(Layout(prepared).tree):
        if leaf.kind == "array":
            found += [""] * leaf.size
        else:
            found.append(".".join(safe_field(part) for part in leaf.key.split(".")))
    return found


def _in_order(node: Any) -> Iterator[Any]:
    for part in getattr(node, "parts", ()):
        if hasattr(part, "parts"):
            yield from _in_order(part)
        else:
            yield part


def _carried(block: Block, entry: Entry, period: float, places: list[str]) -> tuple[str, ...]:
    """Where a parameter's own value lies among the prepared ones; empty where it is worked into others."""
    base, own = _prepared(block, block.params, period), entry.stored(entry.default)
    found: set[int] | None = None
    tried = 0
    for value in _others(entry):
        try:
            moved = _prepared(block, put(block.params, entry.key.split("."), value), period)
        except LeadscrewError:
            continue
        if len(moved) != len(base):
            return ()
        changed = {i for i, (a, b) in enumerate(zip(base, moved, strict=True)) if a != b}
        if not changed or any(moved[i] != value or base[i] != own or not places[i] for i in changed):
            return ()
        found = changed if found is None else found
        if changed != found:
            return ()
        tried += 1
        if tried == 2:
            break
    return tuple(places[i] for i in sorted(found or ()))


def named_options(name: str, knobs: Iterable[Knob]) -> str:
    """The options of choices as constants of C, ``NAME_KNOB_OPTION``."""
    parts, taken = [], set[str]()
    for knob in knobs:
        rows = []
        for number, option in enumerate(knob.names):
            constant = safe(f"{name}_{knob.name}_{option}".replace("-", "_").upper(), taken)
            taken.add(constant)
            rows.append(f"    {constant} = {number}")
        if rows:
            parts.append(
                f"/* params.{knob.places[0]}: {c_comment(knob.doc)} */\nenum {{\n" + ",\n".join(rows) + "\n};\n"
            )
    return "\n".join(parts)


def knobs_of(block: Block, prepared: Any, period: float) -> tuple[tuple[Knob, ...], tuple[str, ...]]:
    """The knobs of a block, and the keys of the parameters that are none (arrays among them)."""
    if block.params is None:
        return (), ()
    places = _places(prepared)
    knobs: list[Knob] = []
    baked: list[str] = []
    taken: set[str] = set()
    for entry in entries(block.params):
        where = () if entry.type == "array" else _carried(block, entry, period, places)
        if not where:
            baked.append(entry.key)
            continue
        name = safe(entry.key.replace(".", "_"), taken)
        taken.add(name)
        low = -math.inf if entry.above == -math.inf else entry.above
        choice = entry.choice
        if choice is not None:
            knobs.append(
                Knob(
                    entry.key, name, "choice", entry.stored(entry.default), where, entry.unit, entry.doc, 0,
                    len(choice.names) - 1, str(choice), choice.names,
                )
            )  # fmt: skip
            continue
        knobs.append(
            Knob(
                entry.key, name, entry.type, entry.default, where, entry.unit, entry.doc, low, entry.below, entry.range
            )
        )
    return tuple(knobs), tuple(baked)
