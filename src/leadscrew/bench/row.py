"""One row of the bench's table."""

from __future__ import annotations

from typing import Any

FIELDS = ("name", "what", "value", "unit", "ratio", "target", "passed", "integrator", "error", "remark")


def row(
    name: str,
    what: str,
    value: float | None = None,
    unit: str = "ns/period",
    *,
    ratio: float | None = None,
    at_most: float | None = None,
    at_least: float | None = None,
    judged: bool = True,
    integrator: str = "",
    error: float | None = None,
    remark: str = "",
) -> dict[str, Any]:
    """A row; the target bounds the ratio where there is one, else the value.

    ``passed`` is True, False, or None where there is no target, nothing was measured, or ``judged`` is False.
    """
    seen = value if ratio is None else ratio
    sign = "x" if ratio is not None else unit
    target, passed = "", None
    if at_most is not None:
        target, passed = f"<= {at_most:g} {sign}", None if seen is None else bool(seen <= at_most)
    if at_least is not None:
        target, passed = f">= {at_least:g} {sign}", None if seen is None else bool(seen >= at_least)
    numbers = (None if x is None else float(x) for x in (value, ratio, error))
    value, ratio, error = numbers
    found = (name, what, value, unit, ratio, target, passed if judged else None, integrator, error, remark)
    return dict(zip(FIELDS, found, strict=True))
