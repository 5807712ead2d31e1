"""What the pictures share: names with units, ends of universes, numbers in words, pens."""

from __future__ import annotations

import math
from typing import Any

from leadscrew.figures.style import BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION
from leadscrew.fuzzy.formats.extent import extent, hull
from leadscrew.fuzzy.system import Output, System, Term, Variable
from leadscrew.util import escape

COLOURS = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, "#4D4D4D")
STYLES = ("-", "--", "-.", (0, (1.2, 1.2)))
GREY = "0.45"
SMALL = 7.0
"""Points of the small text."""
HATCH: dict[str, Any] = {"facecolor": "0.9", "edgecolor": "0.6", "hatch": "////", "linewidth": 0.0}
"""Where there is nothing to show."""


def pen(at: int) -> dict[str, Any]:
    """Colour and line style of the line number ``at``: 28 differ, and neighbours differ in both."""
    return {"color": COLOURS[at % len(COLOURS)], "linestyle": STYLES[at % len(STYLES)]}


def dark(colour: str) -> tuple[float, ...]:
    """A colour that can be read as small text on white."""
    from matplotlib.colors import to_rgb

    return tuple(0.72 * part for part in to_rgb(colour))


def labelled(variable: Variable, most: int = 44) -> str:
    """Name and unit; a name that is too long is cut, the unit stays."""
    unit = f" ({variable.unit})" if variable.unit not in ("", "1") else ""
    return escape.figure(short(variable.name, max(4, most - len(unit))) + unit)


def short(text: str, most: int) -> str:
    """The text, cut where it is longer than ``most`` characters."""
    return text if len(text) <= most else f"{text[: most - 1].rstrip()}…"


def number(value: float, digits: int = 4) -> str:
    """A number with a true minus sign."""
    return f"{value:.{digits}g}".replace("-", "−").replace("inf", "∞")


def ticks(*axes: Any, count: int = 6) -> None:
    """Few round numbers along axes, without zeros at their ends."""
    from matplotlib.ticker import FuncFormatter, MaxNLocator

    for axis in axes:
        axis.set_major_locator(MaxNLocator(count, steps=[1, 2, 2.5, 5, 10]))
        axis.set_major_formatter(FuncFormatter(lambda value, _: number(value, 6)))
        axis.set_tick_params(labelsize=SMALL)


def measure(value: float, unit: str) -> str:
    """A number with its unit."""
    return f"{number(value)} {unit}" if unit not in ("", "1") else number(value)


def ends(system: System, variable: Variable) -> tuple[float, float]:
    """The universe; where it has no end, that of its terms."""
    if math.isfinite(variable.low) and math.isfinite(variable.high):
        return variable.low, variable.high
    known = [(v.low, v.high) for v in system.inputs]
    low, high = hull([extent(term, known) for term in variable.terms])
    low = variable.low if math.isfinite(variable.low) else low
    high = variable.high if math.isfinite(variable.high) else high
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        middle = next((x for x in (low, high) if math.isfinite(x)), 0.0)
        low, high = (low, low + 1.0) if math.isfinite(variable.low) else (middle - 1.0, middle)
    return low, high


def formula(term: Term, system: System) -> str:
    """The consequent of a Takagi-Sugeno rule in words: ``0.5 e + 2 de − 1``."""
    names = [v.name for v in system.inputs]
    *slopes, constant = term.parameters if term.shape == "linear" else (term.parameters[0],)
    parts = [(x, f" {name}") for x, name in zip(slopes, names, strict=False) if x]
    if constant or not parts:
        parts.append((constant, ""))
    text = ""
    for x, name in parts:
        size = "" if abs(x) == 1.0 and name else number(abs(x))
        sign = ("−" if x < 0 else "") if not text else (" − " if x < 0 else " + ")
        text += sign + (size + name).strip()
    return text


def kind(variable: Variable) -> str:
    """What a variable is, for the corner of its panel."""
    if not variable.enabled:
        return "switched off"
    return variable.defuzzifier.replace("_", " ") if isinstance(variable, Output) else "input"
