"""JSON from strangers: one meaning only, and never deep."""

from __future__ import annotations

import json
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
        raise ValueError("a name stands twice in one object")
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


__all__ = ["loads"]
