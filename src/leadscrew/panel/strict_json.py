"""JSON with one meaning: from pages, read strictly and never deep; to pages, with finite numbers only."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

DEEPEST = 8
DIGITS = 64
"""Longest number, in characters."""


def loads(text: str) -> dict[str, Any]:
    """The object that ``text`` holds.

    Raises:
        ValueError: no JSON object, NaN or an infinity, a number beyond float64, a name twice, or nested too deep.
    """
    if _depth(text) > DEEPEST:
        raise ValueError(f"nested deeper than {DEEPEST} levels")
    try:
        found = json.loads(text, parse_constant=_constant, parse_float=_float, parse_int=_int, object_pairs_hook=_once)
    except json.JSONDecodeError as error:
        raise ValueError(f"no JSON ({error.msg} at character {error.pos})") from None
    except RecursionError:
        raise ValueError(f"nested deeper than {DEEPEST} levels") from None
    if not isinstance(found, dict):
        raise ValueError("no JSON object")
    return found


def _depth(text: str) -> int:
    """Deepest nesting of brackets, those inside of texts not counted."""
    deepest = depth = 0
    quoted = escaped = False
    for c in text:
        if escaped:
            escaped = False
        elif quoted:
            escaped = c == "\\"
            quoted = c != '"'
        elif c == '"':
            quoted = True
        elif c in "[{":
            depth += 1
            deepest = max(deepest, depth)
        elif c in "]}":
            depth -= 1
    return deepest


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        raise ValueError("a name is repeated in one object")
    return found


def _constant(word: str) -> Any:
    raise ValueError(f"{word} is not allowed")


def _float(text: str) -> float:
    value = float(text)
    if value in (float("inf"), float("-inf")):
        raise ValueError(f"the number {text[:20]} is beyond what a machine can hold")
    return value


def _int(text: str) -> int:
    if len(text) > DIGITS:
        raise ValueError(f"a whole number of {len(text)} digits is too large")
    return int(text)


def plain(value: Any) -> Any:
    """The value in dicts, lists, text, numbers, true, false and None; a number that is not finite becomes None."""
    if value is None or isinstance(value, bool | str):
        return value
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    if isinstance(value, bool | int | str):
        return value
    if isinstance(value, Mapping):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [plain(v) for v in value]
    return str(value)


def text_of(message: Mapping[str, Any]) -> str:
    """The message as JSON that every browser reads."""
    return json.dumps(plain(message), allow_nan=False, separators=(",", ":"))
