"""How a tangential knife is programmed: feed, axis, corners, blade speed, tolerances; kept in the head of a program.

A tangential word is

    C = sign (phi + d - zero),      sign = 1, or -1 on an axis that counts clockwise

with the unwrapped heading ``phi`` of the line (deg, counter-clockwise from +X), the offset ``d`` (deg,
counter-clockwise) and the heading at which the axis reads 0. Lengths are mm and angles degrees inside; inches exist at
the edge alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from leadscrew.references._gcode_reader import MM_PER_INCH
from leadscrew.util.errors import DataError, ValueRefused

MOST_OFFSET_DEG = 15.0
"""Range of the offset angle, on either side."""
ROUNDING_DEG = 1e-6
"""Angles that differ by less are equal."""
ANGLE_DIGITS = 4
"""Decimals of a word of the axis, deg."""
MARK = "(leadscrew tangent: "
"""How the lines begin that keep the settings in a program."""


@dataclass(frozen=True)
class Settings:
    """Machine and technology of a program for a tangential knife."""

    feed: float = 3000.0
    """mm/min along the line."""
    axis: str = "C"
    """The word of the tangential axis, C or A."""
    zero: float = 0.0
    """Heading at which the axis reads 0, deg."""
    clockwise: bool = False
    """Whether the axis counts clockwise."""
    start_angle: float = 0.0
    """What the axis reads before the program, deg; each line starts at the nearest full turn."""
    corner_angle: float = 20.0
    """Turn in deg above which the knife is lifted, turned and plunged."""
    blend: float = 2.0
    """Length in mm over which a smaller corner is turned."""
    lift: float = 5.0
    """Z of the lifted knife, mm."""
    depth: float = -1.0
    """Z of the cutting knife, mm."""
    plunge: float = 600.0
    """Feed down, mm/min."""
    swivel: float = 720.0
    """Fastest turn of the axis, deg/s; the feed is lowered where a line asks for more."""
    tolerance: float = 0.01
    """How far a move may lie from the line, mm."""
    angle_tolerance: float = 0.2
    """How far the blade may be from its angle between two words, and a move's tangent from the line's, deg.

    The offsets alone keep half of it. With 0.2 the whole LinuxCNC cuts the flower of the study in 1.17 times the time
    at the programmed feed, with 0.1 in 1.29.
    """
    overcut: float = 0.0
    """Length in mm by which a closed line is cut beyond its start."""
    inverse_time: bool = False
    """Feeds as G93, one by the minutes of a move, instead of F in mm/min."""
    inch: bool = False
    """Words in inches (G20)."""
    pricks: str = ""
    """Places X,Y in mm, divided by spaces, where the blade pricks a mark into the sheet before it cuts."""

    def __post_init__(self) -> None:
        if self.axis not in ("A", "C"):
            raise ValueRefused(f"axis = {self.axis!r}: expected C or A")
        for name, low, high, unit in RANGES:
            value = getattr(self, name)
            if not low <= value <= high:
                raise ValueRefused(f"{name} = {value:g}: allowed range is {low:g} to {high:g} {unit}")
        if not self.depth < self.lift:
            raise ValueRefused(f"depth = {self.depth:g}: expected less than lift, {self.lift:g} mm")

        self.places()

    def places(self) -> list[tuple[float, float]]:
        """Where marks are pricked.

        Raises:
            ValueRefused: what is no pair of numbers.
        """
        found = []
        for part in self.pricks.split():
            try:
                x, y = (float(v) for v in part.split(","))
            except ValueError:
                x = y = math.nan
            if not (abs(x) <= 1e5 and abs(y) <= 1e5):
                raise ValueRefused(f"prick {part}: expected X,Y, two numbers in mm")
            found.append((x, y))
        return found

    def rounded(self, mm: float) -> float:
        """A length as it is written, in mm: to 0.1 um, or 0.00001 inch."""
        return round(mm / MM_PER_INCH, 5) * MM_PER_INCH if self.inch else round(mm, 4)

    def lifts(self, turn_deg: float) -> bool:
        """Whether the knife is lifted to turn by this much; at the corner angle itself, to rounding, it is not."""
        return abs(turn_deg) > self.corner_angle + ROUNDING_DEG

    def over_the_sheet(self) -> Settings:
        """The same, where the sheet's top is Z = 0: the knife lifts above it and does not cut above it.

        Raises:
            ValueRefused: not ``lift > 0 >= depth``.
        """
        if not self.lift > 0.0:
            raise ValueRefused(f"lift = {self.lift:g}: expected above 0 mm, the top of the sheet")
        if not self.depth <= 0.0:
            raise ValueRefused(f"depth = {self.depth:g}: expected 0 mm, the top of the sheet, or below")
        return self

    def word(self, angle: float) -> float:
        """What the axis reads at an angle of the blade (heading and offset, deg)."""
        return (zero_free(angle - self.zero)) * (-1.0 if self.clockwise else 1.0)

    def angle(self, word: float) -> float:
        """The angle of the blade at a reading of the axis."""
        return word * (-1.0 if self.clockwise else 1.0) + self.zero

    def lines(self) -> list[str]:
        """The settings as comments of a program."""
        return [f"{MARK}{f.name} = {said(getattr(self, f.name))})" for f in fields(self)]


RANGES = (
    ("feed", 1.0, 1e6, "mm/min"),
    ("zero", -360.0, 360.0, "deg"),
    ("start_angle", -36000.0, 36000.0, "deg"),
    ("corner_angle", 0.0, 180.0, "deg"),
    ("blend", 0.01, 100.0, "mm"),
    ("lift", -1000.0, 1000.0, "mm"),
    ("depth", -1000.0, 1000.0, "mm"),
    ("plunge", 1.0, 1e6, "mm/min"),
    ("swivel", 1.0, 1e5, "deg/s"),
    ("tolerance", 1e-4, 1.0, "mm"),
    ("angle_tolerance", 1e-3, 5.0, "deg"),
    ("overcut", 0.0, 100.0, "mm"),
)
"""Allowed values."""


def zero_free(x: float) -> float:
    """The number, and 0 for -0."""
    return x + 0.0


def said(value: float | str | bool) -> str:
    """A value as it stands in a comment."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return value if isinstance(value, str) else repr(float(value))


def settings_of(text: str, name: str) -> Settings | None:
    """The settings in a program's comments; None where it has none, so is not ours.

    Raises:
        DataError: a comment that says something impossible.
    """
    found: dict[str, str] = {}
    for line in text.splitlines():
        if line.startswith(MARK):
            key, _, value = line.removeprefix(MARK).removesuffix(")").partition(" = ")
            found[key.strip()] = value.strip()
    if not found:
        return None
    values: dict[str, float | str | bool] = {}
    for f in fields(Settings):
        if f.name not in found:
            continue
        value = found[f.name]
        try:
            if isinstance(f.default, bool):
                values[f.name] = {"yes": True, "no": False}[value]
            else:
                values[f.name] = value if isinstance(f.default, str) else float(value)
        except (KeyError, ValueError):
            raise DataError(f"{name}: its comment '{f.name} = {value}' cannot be read") from None
    try:
        return Settings(**values)  # type: ignore[arg-type]
    except ValueRefused as refused:
        raise DataError(f"{name}: its comments say {refused}") from None


def nearest_turn(angle: float, to: float) -> float:
    """The angle plus the full turns that bring it nearest to another, deg."""
    return angle + 360.0 * math.floor((to - angle) / 360.0 + 0.5)
