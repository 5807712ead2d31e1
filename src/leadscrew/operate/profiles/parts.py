"""What several profiles are made of: blocks put into free places, fields that recur, and pulses of parameters."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from leadscrew.operate.profile import Changes, Disturbance, Field

if TYPE_CHECKING:
    from leadscrew.kernel.block import Block
    from leadscrew.kernel.loop import Loop

NEVER_S = 1e9
"""Length of a pulse that stays, in a block that ends its pulses itself."""

LONGEST_S = 600.0

Values = Mapping[str, Any]


def with_blocks(loop: Loop, **blocks: Block) -> Loop:
    """The loop with other blocks in the slots named; everything else, the origin too, as it is."""
    new = copy.copy(loop)
    known = ("program", "sheet", "signals", "module")
    new.__dict__ = {k: v for k, v in loop.__dict__.items() if k not in known}
    new.blocks = {**loop.blocks, **blocks}
    return new


def with_pulse(loop: Loop) -> Loop:
    """The loop with a load pulse of size 0 where nothing loads it."""
    from leadscrew.disturbances._pulse_load import pulse_load

    if loop.blocks["disturbance"] is not None:
        return loop
    return with_blocks(loop, disturbance=pulse_load(size=0.0))


def lasting(value: float = 1.0) -> Field:
    """The field that says for how long."""
    return Field("for_s", "for", "s", 0.0, LONGEST_S, value, "how long it lasts; 0: it stays")


def for_a_while(changes: dict[str, Any], values: Values, seconds: float) -> Changes:
    """The changes now, and the values before them after ``seconds``; 0: they stay."""
    if seconds <= 0.0:
        return [(0.0, changes)]
    return [(0.0, changes), (seconds, {key: values[key] for key in changes})]


def load_pulse(
    unit: str,
    most: float,
    value: float,
    doc: str,
    *,
    at: str = "disturbance",
    factor: float = 1.0,
    label: str = "Load pulse",
    lasts_s: float = 0.2,
    least: float | None = None,
) -> Disturbance:
    """A pulse of the block ``pulse_load`` at the keys ``at.*``; ``factor``: from the shown unit to the load's."""

    def act(fields: Mapping[str, float], now_s: float, values: Values) -> Changes:
        size, seconds = factor * fields["size"], fields["for_s"]
        return [(0.0, {f"{at}.size": size, f"{at}.start": now_s, f"{at}.duration": seconds or NEVER_S})]

    size = Field("size", "size", unit, -most if least is None else least, most, value, "size of the pulse; 0 ends one")
    keys = (f"{at}.size", f"{at}.start", f"{at}.duration")
    return Disturbance("load_pulse", label, doc, (size, lasting(lasts_s)), act, keys)


def to_value(
    name: str, label: str, doc: str, key: str, field: Field, *, factor: float = 1.0, lasts_s: float | None = None
) -> Disturbance:
    """One parameter to ``factor`` times the field's number, for a while or (``lasts_s`` None) for good."""

    def act(fields: Mapping[str, float], now_s: float, values: Values) -> Changes:
        return for_a_while({key: factor * fields[field.name]}, values, fields.get("for_s", 0.0))

    fields = (field,) if lasts_s is None else (field, lasting(lasts_s))
    return Disturbance(name, label, doc, fields, act, (key,))


def multiplied(
    name: str,
    label: str,
    doc: str,
    keys: tuple[str, ...],
    field: Field,
    *,
    times: Callable[[float], float] = float,
    lasts_s: float = 2.0,
) -> Disturbance:
    """All of ``keys`` times the same number, for a while; ``times``: from the field's number to the factor."""

    def act(fields: Mapping[str, float], now_s: float, values: Values) -> Changes:
        by = times(fields[field.name])
        return for_a_while({key: by * values[key] for key in keys}, values, fields["for_s"])

    return Disturbance(name, label, doc, (field, lasting(lasts_s)), act, keys)


def moved_on(origin: str, start: str, target: Field, more: tuple[str, ...] = ()) -> Disturbance:
    """A new move of a reference that goes ``reference.distance`` from ``origin`` at the time ``start``.

    It goes on from where the last move ends; one that has not ended is cut short, and the command jumps there.
    ``more``: keys by which the reference is told from others.
    """
    distance = "reference.distance"

    def act(fields: Mapping[str, float], now_s: float, values: Values) -> Changes:
        end = values[origin] + values[distance]
        return [(0.0, {origin: end, distance: fields["target"] - end, start: now_s})]

    doc = "A new move like the last one, from its end, for this axis and for the one it is compared with."
    return Disturbance("move_to", "Move to", doc, (target,), act, (origin, distance, start, *more))


def noise(
    key: str, unit: str, most: float, value: float, what: str, *, factor: float = 1.0, lasts_s: float = 2.0
) -> Disturbance:
    """More noise of the sensor: the standard deviation of one reading at ``key``."""
    field = Field("deviation", "deviation", unit, 0.0, most, value, f"standard deviation of one reading of {what}")
    doc = f"Noise of {what}: white and Gaussian, one value for each control period."
    return to_value("noise", "Noise", doc, key, field, factor=factor, lasts_s=lasts_s)


__all__ = [
    "LONGEST_S", "NEVER_S", "Values", "for_a_while", "lasting", "load_pulse", "moved_on", "multiplied", "noise",
    "to_value", "with_blocks", "with_pulse",
]  # fmt: skip
