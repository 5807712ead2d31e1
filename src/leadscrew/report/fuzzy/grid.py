"""The values behind a control surface: the outputs over two inputs, or along the only one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from leadscrew.fuzzy.evaluate import compiled
from leadscrew.fuzzy.system import Input, Output, System
from leadscrew.kernel.errors import NameUnknown, ValueRefused
from leadscrew.kernel.sheet import nearest
from leadscrew.report.fuzzy.words import ends

MOST = 2001
"""Points along an axis."""


@dataclass(frozen=True)
class Surface:
    """All outputs over a grid of two inputs, or along one; the other inputs are held."""

    system: System
    x: Input
    y: Input | None
    xs: np.ndarray
    ys: np.ndarray
    """Empty where there is no second input."""
    held: dict[str, float]
    values: np.ndarray
    """Of every output: [y, x, output], or [x, output] where there is no second input."""

    def output(self, name: str | None = None) -> tuple[Output, np.ndarray]:
        """An output, the first enabled one unless named, and its values.

        Raises:
            NameUnknown: there is no such output.
        """
        names = [o.name for o in self.system.outputs]
        on = [o.name for o in self.system.outputs if o.enabled]
        wanted = name if name is not None else (on or names)[0]
        if wanted not in names:
            raise NameUnknown(f"system {self.system.name} has no output {wanted!r}{nearest(wanted, names)}")
        at = names.index(wanted)
        return self.system.outputs[at], self.values[..., at]

    def rows(self) -> tuple[list[str], np.ndarray]:
        """Names of all inputs and outputs, and a row for each point of the grid, the second input fastest."""
        grid = [self.xs] if self.y is None else np.meshgrid(self.xs, self.ys, indexing="ij")
        flat = {self.x.name: grid[0].ravel()}
        if self.y is not None:
            flat[self.y.name] = grid[1].ravel()
        size = grid[0].size
        columns = [flat.get(v.name, np.full(size, self.held.get(v.name))) for v in self.system.inputs]
        values = self.values if self.y is None else self.values.swapaxes(0, 1)
        columns += list(values.reshape(size, -1).T)
        return [v.name for v in (*self.system.inputs, *self.system.outputs)], np.column_stack(columns)


def surface(
    system: System,
    x: str | None = None,
    y: str | None = None,
    at: Mapping[str, float] | None = None,
    points: int = 101,
) -> Surface:
    """All outputs over the universes of two inputs; the first two unless they are named.

    The other inputs are held where ``at`` says, else in the middle of their universe. An output that keeps its last
    value has its default here where no rule fires, as a surface has no last value.

    Raises:
        NameUnknown: no such input.
        ValueRefused: an input used twice or held and drawn, too many points, or a system that cannot be evaluated.
    """
    if not 2 <= points <= MOST:
        raise ValueRefused(f"points = {points}: allowed are 2 to {MOST}")
    first, second = _axes(system, x, y)
    drawn = [v.name for v in (first, second) if v is not None]
    held = _held(system, drawn, at or {})
    xs = np.linspace(*ends(system, first), points)
    ys = np.linspace(*ends(system, second), points) if second is not None else np.empty(0)
    grid = [xs] if second is None else np.meshgrid(xs, ys)
    given: dict[str, Any] = {**dict(zip(drawn, grid, strict=True)), **held}
    made = compiled(replace(system, outputs=tuple(replace(o, lock_previous=False) for o in system.outputs)))
    values = made.many(**given)
    return Surface(system, first, second, xs, ys, held, values.reshape(*grid[0].shape, len(system.outputs)))


def _axes(system: System, x: str | None, y: str | None) -> tuple[Input, Input | None]:
    """The inputs that are drawn."""
    known = {v.name: v for v in system.inputs}
    for name in (x, y):
        if name is not None and name not in known:
            raise NameUnknown(f"system {system.name} has no input {name!r}{nearest(name, list(known))}")
    if x is not None and x == y:
        raise ValueRefused(f"x and y are both {x!r}: they must be two inputs")
    rest = [n for n in known if n not in (x, y)]
    first = x if x is not None else rest.pop(0) if rest else None
    if first is None:
        raise ValueRefused(f"system {system.name} has no other input than {y!r}: draw it as x")
    second = y if y is not None else next((n for n in rest if n != first), None)
    return known[first], None if second is None else known[second]


def _held(system: System, drawn: list[str], at: Mapping[str, float]) -> dict[str, float]:
    """The inputs that are not drawn."""
    names = [v.name for v in system.inputs]
    for name in at:
        if name not in names:
            raise NameUnknown(f"system {system.name} has no input {name!r}{nearest(name, names)}")
        if name in drawn:
            raise ValueRefused(f"the input {name} is drawn, it cannot be held at {at[name]:g} too")
    rest = [v for v in system.inputs if v.name not in drawn]
    return {v.name: float(at[v.name]) if v.name in at else 0.5 * sum(ends(system, v)) for v in rest}
