"""Distributions of one number, as objects and as text.

As text, as the command line has it (bounds are inclusive):

========================================  ==============================================================
``KEY=LOW:HIGH``                          uniform
``KEY=LOW:HIGH:log``                      uniform in the logarithm
``KEY=LOW:HIGH:int``                      whole numbers, each as likely
``KEY=normal:MEAN:DEVIATION``             normal, cut off at four deviations
``KEY=lognormal:MEDIAN:FACTOR``           log-normal: a deviation is the median times FACTOR; cut likewise
``KEY=A|B|C``                             one of these numbers or names, each as likely
========================================  ==============================================================

Every distribution is told by its quantile function: one number from 0 to 1 gives one value.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from leadscrew.kernel.errors import ValueRefused

CUT = 4.0
"""Normal distributions end this many deviations from their middle."""


@dataclass(frozen=True)
class Range:
    """Uniform from ``low`` to ``high``; in the logarithm, or in whole numbers."""

    low: float
    high: float
    log: bool = False
    whole: bool = False

    def __post_init__(self) -> None:
        if not (math.isfinite(self.low) and math.isfinite(self.high) and self.low < self.high):
            raise ValueRefused(f"the range {self.low:g}:{self.high:g} is empty: the low end must be below the high one")
        if self.log and self.low <= 0.0:
            raise ValueRefused(f"the range {self.low:g}:{self.high:g}:log: a logarithm needs a low end above 0")
        if self.whole and (self.low != int(self.low) or self.high != int(self.high)):
            raise ValueRefused(f"the range {self.low:g}:{self.high:g}:int: both ends must be whole numbers")

    def quantile(self, u: np.ndarray) -> np.ndarray:
        """Values of numbers from 0 to 1."""
        if self.whole:
            return np.minimum(np.floor(self.low + u * (self.high - self.low + 1.0)), self.high)
        if self.log:
            a, b = math.log(self.low), math.log(self.high)
            return np.clip(np.exp(a + u * (b - a)), self.low, self.high)
        return np.clip(self.low + u * (self.high - self.low), self.low, self.high)

    def unit(self, x: float) -> float:
        """The number from 0 to 1 of a value; values outside give the nearest end."""
        x = min(max(x, self.low), self.high)
        if self.whole:
            return (round(x) - self.low + 0.5) / (self.high - self.low + 1.0)
        if self.log:
            return math.log(x / self.low) / math.log(self.high / self.low)
        return (x - self.low) / (self.high - self.low)

    @property
    def ends(self) -> tuple[float, float]:
        """The lowest and the highest value."""
        return self.low, self.high

    def __str__(self) -> str:
        return f"{self.low:g}:{self.high:g}{':log' if self.log else ''}{':int' if self.whole else ''}"


@dataclass(frozen=True)
class Normal:
    """Normal, cut off at :data:`CUT` deviations; ``log``: in the logarithm, of a median and a factor."""

    middle: float
    width: float
    log: bool = False

    def __post_init__(self) -> None:
        low = 1.0 if self.log else 0.0
        if not (math.isfinite(self.middle) and math.isfinite(self.width) and self.width > low):
            what = "factor" if self.log else "deviation"
            raise ValueRefused(f"{self}: the {what} must be above {low:g}")
        if self.log and self.middle <= 0.0:
            raise ValueRefused(f"{self}: the median must be above 0")

    def quantile(self, u: np.ndarray) -> np.ndarray:
        """Values of numbers from 0 to 1."""
        from scipy.special import ndtr, ndtri

        tail = ndtr(-CUT)
        z = ndtri(tail + u * (1.0 - 2.0 * tail))
        made: np.ndarray = self.middle * self.width**z if self.log else self.middle + self.width * z
        return made

    def unit(self, x: float) -> float:
        """The number from 0 to 1 of a value; values outside give the nearest end."""
        from scipy.special import ndtr

        z = math.log(x / self.middle) / math.log(self.width) if self.log else (x - self.middle) / self.width
        tail = float(ndtr(-CUT))
        return min(max((float(ndtr(z)) - tail) / (1.0 - 2.0 * tail), 0.0), 1.0)

    @property
    def ends(self) -> tuple[float, float]:
        """The lowest and the highest value."""
        if self.log:
            return self.middle * self.width**-CUT, self.middle * self.width**CUT
        return self.middle - CUT * self.width, self.middle + CUT * self.width

    def __str__(self) -> str:
        return f"{'lognormal' if self.log else 'normal'}:{self.middle:g}:{self.width:g}"


@dataclass(frozen=True)
class Choice:
    """One of some values, each as likely."""

    values: tuple[float, ...]
    names: tuple[str, ...] = field(default=(), repr=False)
    """Of the options of a parameter that has named ones."""

    def __post_init__(self) -> None:
        if len(self.values) < 2 or len(set(self.values)) < len(self.values):
            raise ValueRefused(f"the choice {self}: it needs two different values or more, none twice")

    def quantile(self, u: np.ndarray) -> np.ndarray:
        """Values of numbers from 0 to 1."""
        return np.array(self.values)[np.minimum((u * len(self.values)).astype(int), len(self.values) - 1)]

    def unit(self, x: float) -> float:
        """The number from 0 to 1 of the nearest value."""
        at = int(np.argmin(np.abs(np.array(self.values) - x)))
        return (at + 0.5) / len(self.values)

    @property
    def ends(self) -> tuple[float, float]:
        """The lowest and the highest value."""
        return min(self.values), max(self.values)

    def __str__(self) -> str:
        return "|".join(self.names or (f"{v:g}" for v in self.values))


Distribution = Range | Normal | Choice


def distribution(text: str) -> Distribution:
    """A distribution from its text.

    Raises:
        ValueRefused: it is none, or its range is empty; says what is expected.
    """
    expected = "expected LOW:HIGH, LOW:HIGH:log, LOW:HIGH:int, normal:MEAN:DEVIATION, lognormal:MEDIAN:FACTOR or A|B|C"
    try:
        if "|" in text:
            parts = [p.strip() for p in text.split("|")]
            if all(p.isidentifier() for p in (p.replace("-", "_") for p in parts)):
                return Choice(tuple(map(float, range(len(parts)))), tuple(parts))
            return Choice(tuple(float(p) for p in parts))
        parts = [p.strip() for p in text.split(":")]
        if parts[0] in ("normal", "lognormal"):
            middle, width = (float(x) for x in parts[1:])
            return Normal(middle, width, log=parts[0] == "lognormal")
        low, high, *kind = parts
        if kind not in ([], ["log"], ["int"]):
            raise ValueError
        return Range(float(low), float(high), log=kind == ["log"], whole=kind == ["int"])
    except ValueRefused:
        raise
    except ValueError:
        raise ValueRefused(f"{text!r}: {expected}") from None
