"""Checks where values enter: everything refused here is named with its value, the allowed range and the place."""

from __future__ import annotations

import math
from collections.abc import Mapping
from operator import attrgetter
from types import FunctionType, ModuleType
from typing import TYPE_CHECKING, Any

from leadscrew.kernel.block import Block
from leadscrew.kernel.parameters import checked_replace, entries, nearest
from leadscrew.util.errors import BlockError, ValueRefused

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

_NEEDED = ("reference", "controller", "plant")
_FITS = {"disturbance": ("disturbance",), "output_disturbance": ("disturbance",)}


def number(key: str, value: Any, unit: str) -> float:
    """A finite number, or a refusal."""
    import numpy as np

    if isinstance(value, bool | str) or not isinstance(value, int | float | np.integer | np.floating):
        raise ValueRefused(f"{key} = {value!r}: expected a number{f' in {unit}' if unit else ''}")
    if math.isnan(value):
        raise ValueRefused(f"{key} = {value!r}: not a number (NaN) is not allowed")
    return float(value)


def positive(key: str, value: Any, unit: str) -> float:
    """A finite number above zero, or a refusal."""
    x = number(key, value, unit)
    if not 0.0 < x < math.inf:
        raise ValueRefused(f"{key} = {value!r}: allowed range is (0, inf){f' {unit}' if unit else ''}")
    return x


def whole(key: str, value: Any, low: int, high: int) -> int:
    """A whole number within a range, or a refusal."""
    x = number(key, value, "")
    if x != math.floor(x) or not low <= x <= high:
        raise ValueRefused(f"{key} = {value!r}: allowed are whole numbers from {low} to {high}")
    return int(x)


def in_steps(key: str, value: Any, step: float) -> int:
    """A time as a number of integration steps, or a refusal where it does not divide."""
    x = number(key, value, "s")
    if not 0.0 <= x < math.inf:
        raise ValueRefused(f"{key} = {value!r}: allowed range is [0, inf) s")
    n = round(x / step)
    if abs(x - n * step) > 1e-9 * max(step, x):
        raise ValueRefused(
            f"{key} = {value!r} s is not a multiple of the integration step of {step:g} s (period / substeps); "
            f"the nearest is {n * step:g} s, or choose more substeps"
        )
    return n


def renamed(old: str, value: Any, new: str) -> None:
    """Refuses an argument under a name that it had before."""
    if value is not None:
        raise ValueRefused(f"{old}={value!r}: this argument is {new}= now; write {new}={value!r}")


def one_of(key: str, value: Any, known: list[str]) -> str:
    """A name among several, or a refusal."""
    if value not in known:
        raise ValueRefused(f"{key} = {value!r}: allowed are {', '.join(known)}{_hint(value, known)}")
    return str(value)


def _hint(value: Any, known: list[str]) -> str:
    hint = nearest(str(value), known)
    return hint if hint.startswith("; did") else ""


def check_blocks(blocks: Mapping[str, Block | None]) -> None:
    """Every slot holds a block of the right kind with sound parameters."""
    for slot, block in blocks.items():
        if block is None:
            if slot in _NEEDED:
                raise BlockError(f"a loop needs a {slot}: Loop({slot}=...)")
            continue
        if not isinstance(block, Block):
            raise BlockError(_no_block(slot, block, _FITS.get(slot, (slot,))[0]))
        if block.kind not in _FITS.get(slot, (slot,)):
            raise BlockError(f"{slot} = {block.name!r} is a {block.kind}, not a {_FITS.get(slot, (slot,))[0]}")
        check_params(block, slot)


def _no_block(slot: str, value: Any, kind: str) -> str:
    """What is wrong with a value that is no block, and what to write."""
    if isinstance(value, str):
        return f"{slot} = {value!r} is a text, not a block; write leadscrew.block({value!r})"
    if isinstance(value, ModuleType):
        name = value.__name__.rpartition(".")[2]
        return f"{slot} = {value.__name__} is a module, not a block; write {name}.{name}"
    if isinstance(value, FunctionType):
        return f"{slot} = {value.__name__} is a function, not a block; decorate it with @{kind}(Params(), State())"
    return f"{slot} = {value!r} is not a block; decorate the step with @{kind}(Params(), State())"


def check_params(block: Block, where: str) -> None:
    """Every parameter and every starting state of a block is of its type and within its range."""
    for part in (block.params, block.state):
        for entry in entries(part, f"{where}."):
            if part is block.params or entry.type != "float":
                entry.check(entry.default, block.name)
            key = entry.key.removeprefix(f"{where}.")
            if entry.choice is not None and isinstance(value := attrgetter(key)(part), str):
                raise BlockError(
                    f"{key} = {value!r} ({type(part).__name__}): a NamedTuple of parameters holds the number "
                    f"({entry.choice}); {block.name}({key}={value!r}) takes the name"
                )


def check_metrics(metrics: Mapping[str, Block]) -> dict[str, Block]:
    """Metrics are metric blocks under names that can be fields."""
    for key, block in metrics.items():
        if not (isinstance(key, str) and key.isidentifier() and not key.startswith("_")):
            raise ValueRefused(f"metrics: the name {key!r} must be a word of letters, digits and underscores")
        if not isinstance(block, Block) or block.kind != "metric" or block.state is None or block.output is None:
            raise BlockError(f"metrics.{key} = {block!r} is not a metric block with a state and a value")
        check_params(block, f"metrics.{key}")
    return dict(metrics)


def check_continuous(loop: Loop, method: str | None) -> None:
    """What a continuous loop cannot have; ``method`` is the one that the user named.

    Raises:
        BlockError, ValueRefused: a controller that gives a derivative in a sampled loop; sampled parts, a method, steps
            or delays in a continuous one.
    """
    controller, plant, sensor = (loop.blocks[k] for k in ("controller", "plant", "sensor"))
    assert controller is not None and plant is not None
    if not loop.continuous:
        if controller.continuous:
            raise BlockError(f"{controller.name} gives the derivative of its state; use it with period=None")
        return
    if controller.state is not None and not controller.continuous:
        raise BlockError(f"{controller.name} is a sampled controller; period=None needs one declared continuous=True")
    if "dt" in plant.signals:
        raise BlockError(f"{plant.name} brings its own step; period=None needs a plant that gives its derivative")
    for slot in ("reference", "disturbance", "output_disturbance", "sensor", "actuator"):
        block = loop.blocks[slot]
        if block is not None and (block.state is not None or "noise" in block.signals):
            raise BlockError(f"{slot} {block.name}: with period=None it cannot have state or noise")
    if method not in (None, "rodas"):
        raise ValueRefused(f"method = {method!r}: with period=None the adaptive rodas integrates; leave method out")
    if loop.substeps != 1:
        raise ValueRefused(f"substeps = {loop.substeps}: with period=None rtol and atol set the steps")
    if loop.sent or loop.seen:
        raise ValueRefused("computation_delay and transport_delay need a control period; period is None")
    del sensor


def replaced(params: Any, rest: str, value: Any, key: str) -> Any:
    """Parameters with one changed; the refusal names the full key."""
    try:
        return checked_replace(params, {rest: value}, where=key)
    except ValueRefused as error:
        text = str(error)
        raise ValueRefused(
            text if text.startswith(key) else key.removesuffix(rest) + text.replace(f" ({key})", "")
        ) from None
