"""``--set KEY=VALUE``: texts become values of the type that the data sheet says."""

from __future__ import annotations

import contextlib
import json
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from leadscrew.kernel.parameters import ParameterSpec, nearest, renamed
from leadscrew.util.errors import NameUnknown, ValueRefused

EXPECTED = {
    "float": "a number",
    "int": "a whole number",
    "bool": "true or false",
    "array": "a JSON list of numbers, for example [1, 2.5]",
    "choice": "a name",
}
WORDS = {"true": True, "yes": True, "on": True, "1": True, "false": False, "no": False, "off": False, "0": False}


def parse(pairs: Sequence[str], sheet: Mapping[str, ParameterSpec]) -> dict[str, Any]:
    """The changes that ``KEY=VALUE`` texts ask for, each checked against its data sheet.

    Raises:
        ValueRefused: no ``=``, a key given twice, a text that is no value of that type or is out of range.
        NameUnknown: no such key; names the nearest.
    """
    changes: dict[str, Any] = {}
    for pair in pairs:
        key, equals, text = pair.partition("=")
        key = key.strip()
        if not equals or not key:
            raise ValueRefused(f"--set {pair!r}: expected KEY=VALUE")
        if key not in sheet:
            key = next(iter(renamed({key: ""}, sheet)))  # by its key of today
        if key not in sheet and (limits := _old_limit(key, text, sheet)):
            changes |= limits
            continue
        if key not in sheet:
            raise NameUnknown(f"--set: there is no parameter {key!r}{nearest(key, list(sheet))}")
        if key in changes:
            raise ValueRefused(f"--set {key}: given twice")
        changes[key] = value(sheet[key], text)
    return changes


def _old_limit(key: str, text: str, sheet: Mapping[str, ParameterSpec]) -> dict[str, Any]:
    """Both limits of an output, by the one key that they had in 0.1.0."""
    with contextlib.suppress(ValueError):
        found = renamed({key: _float(text)}, sheet)
        return {k: sheet[k].check(v, "--set") for k, v in found.items() if k in sheet}
    return {}


def value(entry: ParameterSpec, text: str) -> Any:
    """A text as the value of one entry.

    Raises:
        ValueRefused: it is not one, or out of range; names key, text and what is expected.
    """
    try:
        text = text.strip()
        unlimited = text.lstrip("+-") == "inf" and entry.type == "float" and math.isinf(entry.default)
        found = float(text) if unlimited else _READ[entry.type](text)
    except (ValueError, KeyError, RecursionError, OverflowError):
        unit = f" ({entry.unit})" if entry.unit and entry.type != "bool" else ""
        shown = text if len(text) <= 60 else f"{text[:57]}..."
        raise ValueRefused(f"--set {entry.key} = {shown!r}: expected {EXPECTED[entry.type]}{unit}") from None
    return entry.check(found, "--set")


def _float(text: str) -> float:
    found = float(text)
    if math.isinf(found):
        raise ValueError  # no machine has it
    return found


def _int(text: str) -> int:
    try:
        found = int(text)
    except ValueError:
        exact = float(text)
        if exact != int(exact):
            raise
        found = int(exact)
    if abs(found) > 2**53:
        raise ValueError
    return found


def _array(text: str) -> list[Any]:
    found = json.loads(text)
    if not isinstance(found, list) or not all(_numbers(x) for x in found):
        raise ValueError
    return found


def _numbers(item: Any) -> bool:
    if isinstance(item, list):
        return all(_numbers(x) for x in item)
    return isinstance(item, int | float) and not isinstance(item, bool) and math.isfinite(float(item))


_READ: dict[str, Callable[[str], Any]] = {
    "float": _float,
    "int": _int,
    "bool": lambda text: WORDS[text.lower()],
    "array": _array,
    "choice": lambda text: int(text) if text.isdecimal() else text,
}
