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
    integrator: str = "",
    error: float | None = None,
    remark: str = "",
) -> dict[str, Any]:
    """A row; the target bounds the ratio where there is one, else the value."""
    judged = value if ratio is None else ratio
    sign = "x" if ratio is not None else unit
    target, passed = "", None
    if at_most is not None:
        target, passed = f"<= {at_most:g} {sign}", None if judged is None else judged <= at_most
    if at_least is not None:
        target, passed = f">= {at_least:g} {sign}", None if judged is None else judged >= at_least
    found = (name, what, value, unit, ratio, target, passed, integrator, error, remark)
    return dict(zip(FIELDS, found, strict=True))
