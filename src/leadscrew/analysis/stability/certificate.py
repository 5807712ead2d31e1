"""What a stability criterion says of a loop: what is proved, for which loop, how, and with what reserve."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal

from leadscrew.analysis.stability.linear import LinearLoop

if TYPE_CHECKING:
    from leadscrew.figures.figure import Figure

SCHEMA_VERSION = 1

Grade = Literal["certificate", "grid-checked", "refused"]
"""``certificate``: a proof by a linear matrix inequality, verified in exact arithmetic. ``grid-checked``: a frequency
condition that holds at every point of a grid, refined where it is tightest. ``refused``: nothing is proved."""


@dataclass(frozen=True, eq=False)
class Certificate:
    """The result of one criterion on one loop. ``report()`` is the text, ``figure()`` the drawing."""

    criterion: str
    grade: Grade
    statement: str
    """What is proved, or why nothing is: one sentence."""
    loop: Mapping[str, Any]
    """``name, kind`` (sampled or continuous), ``dt_s, dead_time_s, source`` (as exported, or model)."""
    sector: tuple[float, float] | None = None
    """The sector or slope sector that was asked for; infinity above where the largest was sought."""
    limit: float | None = None
    """The largest upper bound of the sector that the criterion proves; infinity where there is none."""
    margin: float | None = None
    """Factor between ``limit`` and the upper bound asked for; above 1 where it is proved."""
    multiplier: float | None = None
    """The multiplier: ``q`` of Popov in s, of Tsypkin and Jury-Lee without unit."""
    grid: Mapping[str, Any] | None = None
    """``from, to`` in rad/s, ``points``, ``refined``; of an LMI, nothing."""
    warnings: list[str] = field(default_factory=list)
    data: Mapping[str, Any] = field(default_factory=dict, repr=False)
    """What the drawing needs, and further numbers of the criterion."""
    drawing: str = field(default="", repr=False)

    @property
    def proved(self) -> bool:
        """Whether the sector asked for is proved, by whatever grade."""
        return self.grade != "refused"

    def warned(self, *sentences: str) -> Certificate:
        """The certificate with more warnings."""
        return replace(self, warnings=[*self.warnings, *(s for s in sentences if s not in self.warnings)])

    def as_dict(self) -> dict[str, Any]:
        """For JSON; what is infinite is the text ``inf``."""
        grid = None if self.grid is None else {k: _plain(v) for k, v in self.grid.items()}
        return {
            "schema_version": SCHEMA_VERSION, "criterion": self.criterion, "grade": self.grade,
            "statement": self.statement, "loop": {k: _plain(v) for k, v in self.loop.items()},
            "sector": None if self.sector is None else [_plain(x) for x in self.sector],
            "limit": _plain(self.limit), "margin": _plain(self.margin), "multiplier": _plain(self.multiplier),
            "grid": grid, "warnings": list(self.warnings),
            "numbers": {k: _plain(v) for k, v in self.data.items() if isinstance(v, int | float | str | bool)},
        }  # fmt: skip

    def report(self) -> str:
        """The certificate as text, a line each for what an engineer asks."""
        rows = [f"{self.criterion}: {self.grade}", f"  {self.statement}", f"  loop        {loop_line(self.loop)}"]
        if self.sector is not None:
            rows.append(f"  asked       {interval(*self.sector)}")
        if self.limit is not None:
            rows.append(f"  limit       {number(self.limit)}")
        if self.margin is not None:
            rows.append(f"  margin      {number(self.margin)} times")
        if self.multiplier is not None:
            rows.append(f"  multiplier  q = {self.multiplier:.4g}")
        if self.grid is not None:
            g = self.grid
            rows.append(
                f"  grid        {g['from']:.3g} to {g['to']:.5g} rad/s, {g['points']} points"
                + (", more where it is tightest" if g.get("refined") else "")
            )
        return "\n".join([*rows, *(f"  warning     {w}" for w in self.warnings)])

    @property
    def limit_text(self) -> str:
        """The limit with four digits, or ``infinite``; empty where there is none."""
        return "" if self.limit is None else number(self.limit)

    @property
    def sector_text(self) -> str:
        """The sector that was asked for; empty where there is none."""
        return "" if self.sector is None else interval(*self.sector)

    def figure(self) -> Figure:
        """The criterion's plot.

        Raises:
            ValueError: this criterion draws nothing.
        """
        if not self.drawing:
            raise ValueError(f"{self.criterion}: has nothing to draw")
        from leadscrew.figures.stability import DRAWINGS

        return DRAWINGS[self.drawing](self)


def of_loop(loop: LinearLoop) -> dict[str, Any]:
    """Which loop a certificate is about."""
    return {
        "name": loop.name,
        "kind": "sampled" if loop.sampled else "continuous",
        "dt_s": loop.dt,
        "dead_time_s": loop.dead_time,
        "order": len(loop.a),
        "source": "as exported" if loop.from_blocks else "model",
    }


def loop_line(loop: Mapping[str, Any]) -> str:
    """The loop in words."""
    if loop["kind"] == "sampled":
        kind = f"sampled at {1.0 / loop['dt_s']:g} Hz, delays as states, order {loop.get('order', '?')}"
    else:
        late = loop.get("dead_time_s") or 0.0
        kind = "continuous" + (f", dead time {1e3 * late:g} ms" if late else "")
    source = "from the steps that are exported" if loop.get("source") == "as exported" else "a model"
    return f"{loop['name'] or 'unnamed'}: {kind}; {source}"


def interval(low: float, high: float) -> str:
    """A sector in words."""
    return f"[{low:g}, {number(high)}{']' if math.isfinite(high) else ')'}"


def number(x: float) -> str:
    """Four digits, or ``infinite``."""
    return "infinite" if math.isinf(x) else f"{x:.4g}"


def _plain(x: Any) -> Any:
    if isinstance(x, bool | str) or x is None:
        return x
    if isinstance(x, float) and not math.isfinite(x):
        return str(x)
    return x.item() if hasattr(x, "item") else x
