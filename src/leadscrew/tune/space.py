"""Parameters that vary: distributions by dotted key, drawn as Latin hypercubes, Sobol points or at random.

A point of the unit cube gives one set of parameters, whatever the sampling; how a distribution is written stands in
:mod:`leadscrew.tune.distributions`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, cast

import numpy as np

from leadscrew.kernel.errors import NameUnknown, ValueRefused
from leadscrew.kernel.sheet import Entry, nearest
from leadscrew.tune.distributions import Choice, Distribution, Normal, Range, distribution

__all__ = ["METHODS", "Choice", "Distribution", "Given", "Method", "Normal", "Range", "Space", "check_method", "cube",
           "distribution"]  # fmt: skip

Method = Literal["lhs", "sobol", "random"]
METHODS = ("lhs", "sobol", "random")
Given = Mapping[str, Distribution | str | tuple[float, float]] | Sequence[str]
"""What a space is made of: a mapping (distributions, texts, or pairs of ends), or ``KEY=...`` texts."""


@dataclass(frozen=True)
class Space:
    """Distributions by dotted key, in a fixed order."""

    items: tuple[tuple[str, Distribution], ...]

    @staticmethod
    def of(given: Given | Space | None) -> Space:
        """What is given as a space; nothing gives an empty one.

        Raises:
            ValueRefused: a text that is none, a key given twice.
        """
        if isinstance(given, Space):
            return given
        given = given or {}
        if not isinstance(given, Mapping):
            pairs: list[tuple[str, Any]] = []
            for text in given:
                key, equals, rest = text.partition("=")
                if not equals or not key.strip():
                    raise ValueRefused(f"{text!r}: expected KEY=LOW:HIGH or another distribution")
                pairs.append((key.strip(), rest))
        else:
            pairs = list(given.items())
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

    def checked(self, sheet: Mapping[str, Entry], where: str) -> Space:
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


def _options(entry: Entry, dist: Distribution, where: str) -> Choice:
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
