"""What of a running machine can be set, what only at its start, and the units of its columns."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.figures.signals import column_units
from leadscrew.kernel.layout import Layout, is_branch
from leadscrew.kernel.parameters import ParameterSpec, entries, nearest, put, renamed
from leadscrew.util.errors import LeadscrewError, NameUnknown, ValueRefused

if TYPE_CHECKING:
    from leadscrew.kernel.block import Block
    from leadscrew.kernel.loop import Loop
    from leadscrew.operate.axes import Axes

AT_START = "takes effect at the next start"
SIZE = "changes the size of the loop; takes effect at the next start"


def sheet(axes: Axes) -> dict[str, ParameterSpec]:
    """Every parameter of the loop but those of its metrics; of two axes also each of the second."""
    own = {k: e for k, e in axes.lives[0].loop.sheet.items() if not k.startswith("metrics.")}
    if len(axes.lives) == 1:
        return own
    second = axes.lives[1].loop.sheet
    return own | {f"y.{k}": replace(second[k], key=f"y.{k}") for k in own}


def at_start(loop: Loop, settable: Mapping[str, ParameterSpec]) -> dict[str, tuple[ParameterSpec, str]]:
    """What cannot change in the run, and why: the scenario's parameters, sizes, what only the start depends on.

    ``settable`` is what the experiment can be given. Sizes are found by trying neighbouring values, block by block.
    """
    found = {k: (e, AT_START) for k, e in settable.items() if k.startswith("scenario.")}
    for slot, block in loop.blocks.items():
        if block is None or block.params is None or (block.prepare is None and block.initial is None):
            continue
        for entry in entries(block.params):
            why = _why(loop, slot, block, entry)
            if why:
                key = f"{slot}.{entry.key}"
                found[key] = (loop.sheet[key], why)
    return found


def _why(loop: Loop, slot: str, block: Block, entry: ParameterSpec) -> str:
    params, state = loop.prepared(block, slot), loop.start_state(block)
    tried = effective = False
    for value in _neighbours(entry):
        other = replace(block, params=put(block.params, entry.key.split("."), value))
        try:
            then = loop.prepared(other, slot), loop.start_state(other)
        except (LeadscrewError, ArithmeticError, ValueError, IndexError):
            continue
        if any(Layout(a).keys != Layout(b).keys for a, b in zip((params, state), then, strict=True)):
            return SIZE
        tried = tried or _numbers(state) != _numbers(then[1])
        effective = effective or _numbers(params) != _numbers(then[0])
    return AT_START if tried and not effective else ""


def _numbers(value: Any) -> list[bytes]:
    return [part.tobytes() for part in Layout(value).pack(value)] if is_branch(value) else [np.float64(value).tobytes()]


def _neighbours(entry: ParameterSpec) -> Iterator[Any]:
    """Other values that the parameter may have."""
    if entry.type == "array":
        return
    if entry.choice is not None:
        yield from range(len(entry.choice.names))
        return
    was = entry.default
    wanted: list[Any] = [not was] if entry.type == "bool" else [was + 1, was - 1, 2 * was]
    if entry.type == "float":
        wanted += [0.5 * was]
    for value in wanted:
        try:
            yield entry.check(value)
        except ValueRefused:
            continue


def checked(changes: Mapping[str, Any], known: Mapping[str, ParameterSpec], fixed: Mapping[str, str]) -> dict[str, Any]:
    """The changes with their values in the parameters' types.

    Raises:
        NameUnknown: no such parameter.
        ValueRefused: nothing to set, out of range, of another type, or not to be changed in the run.
    """
    if not changes:
        raise ValueRefused("there is nothing to set: give at least one parameter and its value")
    changes = renamed(changes, known)
    for key in changes:
        own = key.removeprefix("x.")
        if key in fixed:
            raise ValueRefused(f"{key} cannot change in the run: it {fixed[key]}")
        if key in ("seed", "engine", "period", "bound", "substeps"):
            raise ValueRefused(f"{key} cannot change in the run: it {AT_START}")
        if key not in known and own not in known:
            raise NameUnknown(f"there is no parameter {key!r}{nearest(key, list(known))}")
    return {k: _value(k, known[k if k in known else k.removeprefix("x.")], v) for k, v in changes.items()}


def _value(key: str, entry: ParameterSpec, value: Any) -> Any:
    """Checked; infinite only where the parameter is so already, as a limit that is none."""
    found = entry.check(value)
    if entry.type == "float" and math.isinf(found) and math.isfinite(entry.default):
        unit = f" {entry.unit}" if entry.unit else ""
        raise ValueRefused(f"{key} = {value!r}: expected a finite number{unit}, at the start it is {entry.default:g}")
    return _plain(found)


def _plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray) else value


def plain(values: Mapping[str, Any]) -> dict[str, Any]:
    """Values as files and messages hold them: arrays as lists."""
    return {k: _plain(v) for k, v in values.items()}


def units(axes: Axes) -> dict[str, str]:
    """The unit of every column, as far as signals, states and blocks say; those of Y are those of X."""
    own = column_units(axes.lives[0].loop)
    return {c: own[c.removeprefix("y.")] for c in axes.columns}


__all__ = ["AT_START", "SIZE", "at_start", "checked", "plain", "sheet", "units"]
