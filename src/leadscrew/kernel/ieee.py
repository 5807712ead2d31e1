"""Division as IEEE-754 has it, for the plain Python engine, remembering where a finite quotient was lost."""

from __future__ import annotations

import math
import sys
from typing import Any

lost: dict[str, Any] = {}
"""Where the last division of finite numbers gave a value that is not finite: ``file``, ``line``, ``what``."""


def _remember(what: str) -> None:
    frame = sys._getframe(2)
    lost.update(file=frame.f_code.co_filename, line=frame.f_lineno, what=what)


def ieee_divide(a: Any, b: Any) -> Any:
    """``a / b``; infinity or NaN where ``b`` is zero."""
    if b != 0:
        try:
            return a / b
        except OverflowError:
            return math.inf if (a > 0) == (b > 0) else -math.inf
    _remember(f"{a!r} / {b!r}")
    if a != a or a == 0:
        return math.nan
    return math.copysign(math.inf, a) * math.copysign(1.0, b)


def ieee_floor_divide(a: Any, b: Any) -> Any:
    """``a // b``; where ``b`` is zero the IEEE quotient for floats, 0 for integers; NaN of an infinite ``a``."""
    if b != 0 and (isinstance(a, int) or math.isfinite(a)):
        return a // b
    _remember(f"{a!r} // {b!r}")
    if isinstance(a, int) and isinstance(b, int):
        return 0
    return ieee_divide(float(a), b) if b == 0 else math.nan


def ieee_modulo(a: Any, b: Any) -> Any:
    """``a % b``; for floats NaN, for integers 0 where ``b`` is zero."""
    if b != 0 and (isinstance(a, int) or math.isfinite(a)):
        return a % b
    _remember(f"{a!r} % {b!r}")
    return 0 if isinstance(a, int) and isinstance(b, int) else math.nan


def ieee_range(*bounds: int) -> range:
    """``range``, empty where the step is zero."""
    return range(*bounds) if len(bounds) < 3 or bounds[2] != 0 else range(0)


OPERATORS: dict[str, Any] = {f.__name__: f for f in (ieee_divide, ieee_floor_divide, ieee_modulo)} | {
    "range": ieee_range
}
