"""Options of the form ``KEY=VALUE``, given several times or with commas between them."""

from __future__ import annotations

import math
from collections.abc import Sequence

from leadscrew.util.errors import ValueRefused


def texts(option: str, pairs: Sequence[str] | None, expected: str) -> dict[str, str]:
    """What each pair says, by its key.

    Raises:
        ValueRefused: no ``=``, an empty side, a key given twice; says what was ``expected``.
    """
    found: dict[str, str] = {}
    for pair in pairs or ():
        key, equals, value = (part.strip() for part in pair.partition("="))
        if not equals or not key or not value:
            raise ValueRefused(f"{option} {pair!r}: expected {expected}")
        if key in found:
            raise ValueRefused(f"{option} {key}: given twice")
        found[key] = value
    return found


def values(option: str, pairs: Sequence[str] | None, expected: str) -> dict[str, float]:
    """The number of each pair, by its key.

    Raises:
        ValueRefused: as :func:`texts`, or a value that is no finite number.
    """
    return {key: _number(option, key, text) for key, text in texts(option, pairs, expected).items()}


def _number(option: str, key: str, text: str) -> float:
    try:
        found = float(text)
    except ValueError:
        found = math.nan
    if not math.isfinite(found):
        raise ValueRefused(f"{option} {key}={text}: expected a number behind the =")
    return found
