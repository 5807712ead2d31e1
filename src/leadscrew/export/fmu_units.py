"""Units as FMI wants them: exponents of the SI base units and a factor."""

from __future__ import annotations

import math
import re
from fractions import Fraction

BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")


def _unit(factor: Fraction | int = 1, **exponents: int) -> tuple[Fraction, dict[str, int]]:
    return Fraction(factor), exponents


_TURN = Fraction(math.pi)
_KNOWN = {
    "1": _unit(),
    "%": _unit(Fraction(1, 100)),
    "m": _unit(m=1),
    "g": _unit(Fraction(1, 1000), kg=1),
    "s": _unit(s=1),
    "min": _unit(60, s=1),
    "h": _unit(3600, s=1),
    "A": _unit(A=1),
    "K": _unit(K=1),
    "mol": _unit(mol=1),
    "cd": _unit(cd=1),
    "rad": _unit(rad=1),
    "deg": _unit(_TURN / 180, rad=1),
    "rev": _unit(2 * _TURN, rad=1),
    "rpm": _unit(_TURN / 30, rad=1, s=-1),
    "Hz": _unit(s=-1),
    "N": _unit(kg=1, m=1, s=-2),
    "Nm": _unit(kg=1, m=2, s=-2),
    "J": _unit(kg=1, m=2, s=-2),
    "W": _unit(kg=1, m=2, s=-3),
    "V": _unit(kg=1, m=2, s=-3, A=-1),
    "C": _unit(A=1, s=1),
    "ohm": _unit(kg=1, m=2, s=-3, A=-2),
    "H": _unit(kg=1, m=2, s=-2, A=-2),
    "F": _unit(kg=-1, m=-2, s=4, A=2),
    "T": _unit(kg=1, s=-2, A=-1),
    "Pa": _unit(kg=1, m=-1, s=-2),
}
_PREFIXES = {"G": 9, "M": 6, "k": 3, "c": -2, "m": -3, "u": -6, "µ": -6, "μ": -6, "n": -9}
_TOKENS = re.compile(r"\s*(/|\*|\(|\)|\^-?\d+|[A-Za-zµμ%]+|1)\s*")


def base_units(text: str) -> tuple[float, dict[str, int]] | None:
    """Factor and exponents of a unit such as ``V/(mm s)``; ``None`` where it is not made of known units."""
    tokens, at = [], 0
    while at < len(text):
        found = _TOKENS.match(text, at)
        if not found:
            return None
        tokens.append(found[1])
        at = found.end()
    try:
        factor, exponents = _product(tokens)
    except (LookupError, ValueError):
        return None
    return (float(factor), exponents) if not tokens else None


def _product(tokens: list[str]) -> tuple[Fraction, dict[str, int]]:
    """Takes factors, left to right, up to the end or a closing bracket."""
    factor, exponents = _power(tokens)
    while tokens and tokens[0] != ")":
        sign = -1 if tokens[0] == "/" else 1
        if tokens[0] in "/*":
            tokens.pop(0)
        more, of = _power(tokens)
        factor *= more**sign
        exponents = {b: exponents.get(b, 0) + sign * of.get(b, 0) for b in BASE}
    return factor, {b: n for b, n in exponents.items() if n}


def _power(tokens: list[str]) -> tuple[Fraction, dict[str, int]]:
    """Takes one unit or bracket, with its exponent."""
    first = tokens.pop(0)
    if first == "(":
        factor, exponents = _product(tokens)
        if tokens.pop(0) != ")":
            raise ValueError("a bracket is not closed")
    else:
        factor, exponents = _named(first)
    if tokens and tokens[0].startswith("^"):
        power = int(tokens.pop(0)[1:])
        factor, exponents = factor**power, {b: n * power for b, n in exponents.items()}
    return factor, exponents


def _named(name: str) -> tuple[Fraction, dict[str, int]]:
    if name in _KNOWN:
        return _KNOWN[name]
    factor, exponents = _KNOWN[name[1:]]
    return factor * Fraction(10) ** _PREFIXES[name[0]], exponents
