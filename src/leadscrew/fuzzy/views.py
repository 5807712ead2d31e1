"""What the explanation of a running controller is made of: plain dicts of finite numbers and short texts, for JSON."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple, Protocol

MOST_RULES = 12
"""Rules that are shown, the largest shares first."""
NAMES = {
    3: ("N", "ZO", "P"),
    5: ("NB", "NS", "ZO", "PS", "PB"),
    6: ("NB", "NM", "NS", "PS", "PM", "PB"),
    7: ("NB", "NM", "NS", "ZO", "PS", "PM", "PB"),
}
"""Names of the sets of a partition by how many there are."""


class Now(NamedTuple):
    """A running controller after a period."""

    params: Any
    """Its parameters, as a user sets them."""
    state: Any
    row: Mapping[str, float]
    """The signals of the period."""
    dt: float
    live: Any = None


class View(Protocol):
    """The explanation of one controller: a plain function of its parameters, state and signals, with what it keeps."""

    @property
    def views(self) -> tuple[str, ...]:
        """Of ``rules``, ``sets``, ``phase``."""
        ...

    def look(self, now: Now) -> dict[str, Any]:
        """The views by name."""
        ...


class Acting(NamedTuple):
    """A rule that fires."""

    number: int
    text: str
    share: float
    """Its part of the output; those of all rules sum to one."""
    strength: float
    value: float | None = None
    """What it concludes, where it is a number."""
    prior: float | None = None
    """What it concluded before anything was learned."""


class Quantity(NamedTuple):
    """An input of the rules as the machine has it, and its sets as they are now."""

    name: str
    value: float
    unit: str
    full_low: float
    full_high: float
    low: float
    high: float
    scale: float
    """The value over it is what the rules see."""
    names: Sequence[str]
    points: Sequence[Sequence[Sequence[float]]]
    """Corners of each set, in the unit of the value."""
    degrees: Sequence[float]
    seen: float | None = None
    """The value as the rules see it, where it is held before it reaches them."""


def number(x: Any) -> float | None:
    """A finite number, or None."""
    x = float(x)
    return x if math.isfinite(x) else None


def rounded_up(x: float) -> float:
    """The next of 1, 2, 5 times a power of ten: an axis that does not jitter."""
    if not (math.isfinite(x) and x > 0.0):
        return 1.0
    power = 10.0 ** math.floor(math.log10(x))
    return next(m * power for m in (1.0, 2.0, 5.0, 10.0) if m * power >= x * (1.0 - 1e-12))


def set_names(count: int) -> tuple[str, ...]:
    """The usual names of so many sets; numbers where there are none."""
    return NAMES.get(count) or tuple(f"set {k + 1}" for k in range(count))


def closest(names: Sequence[str], peaks: Sequence[float], value: float) -> str:
    """The name of the set whose peak lies closest to a value."""
    return names[min(range(len(names)), key=lambda k: abs(peaks[k] - value))]


def triangles(centres: Sequence[float], factor: float, low: float, high: float) -> list[list[list[float]]]:
    """Corners of the sets of a triangular partition times ``factor``, the shoulders drawn to the universe's ends."""
    c = [factor * x for x in centres]
    sets = []
    for k, peak in enumerate(c):
        corners = [[c[k - 1], 0.0], [peak, 1.0]] if k else [[peak, 1.0]]
        corners += [[c[k + 1], 0.0]] if k + 1 < len(c) else []
        first, last = (low, high) if factor > 0.0 else (high, low)
        if k == 0 and (peak - first) * factor > 0.0:
            corners.insert(0, [first, 1.0])
        if k + 1 == len(c) and (last - peak) * factor > 0.0:
            corners.append([last, 1.0])
        sets.append(corners if factor > 0.0 else corners[::-1])
    return sets


def two_degrees(count: int, lower: int, upper_membership: float) -> list[float]:
    """Degrees of all sets of a partition of unity at a point: two of them are not 0."""
    degrees = [0.0] * count
    degrees[lower] = 1.0 - upper_membership
    degrees[lower + 1] = upper_membership
    return degrees


def sets_view(inputs: Iterable[Quantity]) -> dict[str, Any]:
    """The view ``sets``."""
    return {
        "inputs": [
            {
                "name": q.name, "value": number(q.value if q.seen is None else q.seen), "unit": q.unit,
                "full_low": number(q.full_low), "full_high": number(q.full_high),
                "low": number(q.low), "high": number(q.high),
                "sets": [
                    {"name": n, "points": [[float(x), float(y)] for x, y in p], "degree": number(d)}
                    for n, p, d in zip(q.names, q.points, q.degrees, strict=True)
                ],
            }
            for q in inputs
        ]
    }  # fmt: skip


def rules_view(
    inputs: Iterable[Quantity],
    outputs: Iterable[tuple[str, float, str]],
    acting: Iterable[Acting],
    total: int,
    note: str = "",
) -> dict[str, Any]:
    """The view ``rules``; ``outputs``: name, value, unit."""
    rules = sorted((a for a in acting if a.share > 0.0 or a.strength > 0.0), key=lambda a: (-a.share, -a.strength))
    return {
        "inputs": [
            {
                "name": q.name, "value": number(q.value), "unit": q.unit, "low": number(q.low), "high": number(q.high),
                "scale": number(q.scale),
            }
            for q in inputs
        ],
        "outputs": [{"name": n, "value": number(v), "unit": u} for n, v, u in outputs],
        "rules": [
            {
                "number": a.number, "text": a.text, "share": number(a.share), "strength": number(a.strength),
                "value": None if a.value is None else number(a.value),
                "prior": None if a.prior is None else number(a.prior),
            }
            for a in rules[:MOST_RULES]
        ],
        "total": total,
        "note": note,
    }  # fmt: skip
