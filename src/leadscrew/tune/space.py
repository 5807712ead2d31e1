"""Parameters that vary: distributions by dotted key, drawn as Latin hypercubes, Sobol points or at random.

A point of the unit cube gives one set of parameters, whatever the sampling. Distributions as text, as the command line
has them (bounds are inclusive):

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
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, cast

import numpy as np

from leadscrew.kernel.parameters import ParameterSpec, nearest
from leadscrew.util.errors import NameUnknown, ValueRefused, entry_point

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


__all__ = ["METHODS", "Choice", "Distribution", "Given", "Method", "Normal", "Range", "Space", "check_method", "cube",
           "distribution"]  # fmt: skip

Method = Literal["lhs", "sobol", "random"]
METHODS = ("lhs", "sobol", "random")
Given = Mapping[str, Distribution | str | tuple[float, float]] | Sequence[str]
"""What a space is made of: a mapping (distributions, texts, or pairs of ends), or ``KEY=...`` texts."""


@entry_point
@dataclass(frozen=True)
class Space:
    """Distributions by dotted key, in a fixed order."""

    items: tuple[tuple[str, Distribution], ...]

    @staticmethod
    def of(space: Given | Space | None) -> Space:
        """What is given as a space; nothing gives an empty one.

        Raises:
            ValueRefused: a text that is none, a key given twice.
        """
        if isinstance(space, Space):
            return space
        space = space or {}
        if not isinstance(space, Mapping):
            pairs: list[tuple[str, Any]] = []
            for text in space:
                key, equals, rest = text.partition("=")
                if not equals or not key.strip():
                    raise ValueRefused(f"{text!r}: expected KEY=LOW:HIGH or another distribution")
                pairs.append((key.strip(), rest))
        else:
            pairs = list(space.items())
        made: dict[str, Distribution] = {}
        for key, value in pairs:
            if key in made:
                raise ValueRefused(f"{key}: given twice")
            try:
                made[key] = (
                    distribution(value)
                    if isinstance(value, str)
                    else (value if isinstance(value, Range | Normal | Choice) else Range(*value))
                )
            except ValueRefused as error:
                raise ValueRefused(f"{key}: {error}") from None
        return Space(tuple(made.items()))

    @property
    def keys(self) -> tuple[str, ...]:
        """The dotted keys."""
        return tuple(k for k, _ in self.items)

    def __len__(self) -> int:
        return len(self.items)

    def checked(self, sheet: Mapping[str, ParameterSpec], where: str) -> Space:
        """The space with names of options as their numbers; refuses ends outside the data sheets.

        Raises:
            NameUnknown, ValueRefused: names the key, the value and what is allowed.
        """
        items: list[tuple[str, Distribution]] = []
        for key, dist in self.items:
            if key not in sheet:
                raise NameUnknown(f"{where}: there is no parameter {key!r}{nearest(key, list(sheet))}")
            entry = sheet[key]
            if entry.choice is not None:
                items.append((key, _options(entry, dist, where)))
                continue
            if isinstance(dist, Choice) and dist.names:
                raise ValueRefused(f"{where} {key} = {dist}: expected numbers")
            if entry.type not in ("float", "int"):
                raise ValueRefused(f"{where} {key}: it is of type {entry.type}; only numbers vary")
            if entry.type == "int" and not (isinstance(dist, Choice) or getattr(dist, "whole", False)):
                raise ValueRefused(f"{where} {key} = {dist}: it is a whole number; write LOW:HIGH:int")
            for end in dist.ends:
                entry.check(int(end) if entry.type == "int" else end, where)
            items.append((key, dist))
        return Space(tuple(items))

    def values(self, unit: np.ndarray) -> dict[str, np.ndarray]:
        """The values of points of the unit cube, ``[point, key]``."""
        return {key: dist.quantile(unit[:, i]) for i, (key, dist) in enumerate(self.items)}

    def units(self, values: Mapping[str, float]) -> np.ndarray:
        """The point of the unit cube of some values; 1/2 for a key that has none."""
        return np.array([dist.unit(values[key]) if key in values else 0.5 for key, dist in self.items])

    def sample(self, count: int, seed: int = 0, method: Method = "lhs") -> dict[str, np.ndarray]:
        """Values of ``count`` points: a Latin hypercube, scrambled Sobol points (SciPy), or independent draws."""
        return self.values(cube(count, len(self), seed, method))


def _options(entry: ParameterSpec, dist: Distribution, where: str) -> Choice:
    if not isinstance(dist, Choice):
        some = "|".join(entry.choice.names[:2]) if entry.choice else ""
        raise ValueRefused(f"{where} {entry.key} = {dist}: it is one of {entry.range}; write {some}")
    names = [entry.check(value, where) for value in dist.names or dist.values]
    return Choice(tuple(float(entry.stored(name)) for name in names), tuple(names))


def check_method(name: str) -> Method:
    """The sampling of that name.

    Raises:
        NameUnknown: there is none; names the nearest.
    """
    if name not in METHODS:
        raise NameUnknown(f"there is no sampling {name!r}{nearest(name, list(METHODS))}")
    return cast(Method, name)


def cube(count: int, dimensions: int, seed: int, method: Method = "lhs") -> np.ndarray:
    """Points of the unit cube, ``[point, dimension]``.

    Raises:
        NameUnknown: there is no such method.
    """
    check_method(method)
    if dimensions == 0:
        return np.zeros((count, 0))
    rng = np.random.default_rng(seed)
    if method == "random":
        return rng.random((count, dimensions))
    from scipy.stats import qmc

    if method == "lhs":
        return np.asarray(qmc.LatinHypercube(dimensions, rng=rng).random(count))
    sobol = qmc.Sobol(dimensions, rng=rng)
    return np.asarray(sobol.random_base2(max(0, math.ceil(math.log2(count)))))[:count]
