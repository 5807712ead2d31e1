"""The control surface of a system: an output over two of its inputs, or over its only one."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.figures.style import BLUE
from leadscrew.fuzzy.evaluate import compiled
from leadscrew.fuzzy.system import Input, Output, System
from leadscrew.kernel.parameters import nearest
from leadscrew.report.fuzzy.words import HATCH, SMALL, ends, labelled, measure, number, short, ticks
from leadscrew.util import escape
from leadscrew.util.errors import NameUnknown, ValueRefused

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from leadscrew.figures.figure import Figure


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


KINDS = ("both", "map", "3d")
COLOURS = "viridis"
"""Perceptually uniform, and told apart with every common colour blindness and in grey."""
FACES = 36
"""Faces of the surface along an axis."""


def surface_figure(
    system: System | Surface,
    x: str | None = None,
    y: str | None = None,
    output: str | None = None,
    at: Mapping[str, float] | None = None,
    points: int = 101,
    kind: str = "both",
) -> Figure:
    """The control surface as a map with contours, in three dimensions, or both; of one input, a line.

    Where there is no value (no rule fires and there is no default) the map is hatched.

    Raises:
        NameUnknown: no such input or output.
        ValueRefused: see :func:`surface`; or no such kind.
    """
    from leadscrew.figures.figure import Figure

    if kind not in KINDS:
        raise ValueRefused(f"kind = {kind!r}: there are {', '.join(KINDS)}")
    made = system if isinstance(system, Surface) else surface(system, x, y, at, points)
    drawn, z = made.output(output)
    if made.y is None:
        figure = Figure(figsize=(5.0, 3.2), layout="constrained")
        _line(figure.add_subplot(), made, drawn, z)
    else:
        figure = _two_inputs(made, drawn, z, kind)
    figure.suptitle(_title(made, drawn), fontsize="medium")
    return figure


def _title(made: Surface, output: Output) -> str:
    """The system, the output, and what is held."""
    title = f"{short(made.system.name, 50)}: {short(output.name, 40)}"
    if made.held:
        units = {v.name: v.unit for v in made.system.inputs}
        title += " at " + ", ".join(f"{n} = {measure(v, units[n])}" for n, v in made.held.items())
    return escape.figure(title)


def _why(made: Surface, output: Output) -> str:
    """Why there is no value."""
    if not output.enabled:
        return "no value: the output is switched off"
    return "no rule fires: the last value stays" if output.lock_previous else "no value: no rule fires"


def _line(ax: Axes, made: Surface, output: Output, z: np.ndarray) -> None:
    ax.plot(made.xs, z, color=BLUE, linewidth=1.5)
    gap = ~np.isfinite(z)
    if gap.any():
        where: Any = gap.tolist()
        ax.fill_between(made.xs, 0, 1, where=where, transform=ax.get_xaxis_transform(), step="mid", zorder=3, **HATCH)
        _say_gaps(ax, made, output)
    ax.set_xlabel(labelled(made.x), fontsize=9)
    ax.set_ylabel(labelled(output), fontsize=9)
    ax.set_xlim(made.xs[0], made.xs[-1])
    ticks(ax.xaxis, ax.yaxis)
    ax.grid(color="0.92", linewidth=0.6)


def _say_gaps(ax: Axes, made: Surface, output: Output) -> None:
    """What the hatching means, above the axes."""
    from matplotlib.patches import Patch

    patch: Any = Patch(label=_why(made, output), **HATCH)
    ax.legend(handles=[patch], fontsize=SMALL, loc="lower left", bbox_to_anchor=(0.0, 1.0), frameon=False,
              borderaxespad=0.2)  # fmt: skip


def _limits(z: np.ndarray) -> tuple[float, float]:
    """The range of the colours: that of the values, wider where they are all the same."""
    known = z[np.isfinite(z)]
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 0.0)
    return (low, high) if high - low > 1e-9 * max(1.0, abs(low), abs(high)) else (low - 0.5, low + 0.5)


def _two_inputs(made: Surface, output: Output, z: np.ndarray, kind: str) -> Figure:
    from leadscrew.figures.figure import Figure

    both = kind == "both"
    figure = Figure(figsize=(8.8, 3.7) if both else (5.0, 4.0), layout="constrained")
    figure.get_layout_engine().set(wspace=0.1 if both else 0.02)  # type: ignore[union-attr,call-arg]
    shown = None
    if kind != "3d":
        ax = figure.add_subplot(1, 1 + both, 1)
        shown = _map(ax, made, output, z)
        bar = figure.colorbar(shown, ax=ax, pad=0.02)
    if kind != "map":
        ax = figure.add_subplot(1, 1 + both, 1 + both, projection="3d")
        relief = _relief(ax, made, output, z)
        if not both and relief is not None:
            shown = relief
            bar = figure.colorbar(relief, ax=ax, shrink=0.7, pad=0.16)
    if shown is not None:
        bar.set_label(labelled(output), fontsize=9)
        ticks(bar.ax.yaxis, count=8)
    return figure


def _levels(z: np.ndarray) -> np.ndarray:
    """Where contours go: round numbers inside the range that no plateau has, where a contour would be noise."""
    from matplotlib.ticker import MaxNLocator

    known = z[np.isfinite(z)]
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 0.0)
    wide = high - low
    if not wide > 1e-9 * max(1.0, abs(low), abs(high)):
        return np.empty(0)
    levels = np.asarray(MaxNLocator(9, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high), dtype=float)
    inside = levels[(levels > low + 0.01 * wide) & (levels < high - 0.01 * wide)]
    crowded = [np.mean(np.abs(known - v) < 0.003 * wide) > 0.04 for v in inside]
    return inside[~np.array(crowded, dtype=bool)]


def _map(ax: Axes, made: Surface, output: Output, z: np.ndarray) -> Any:
    """The heat map with its contours."""
    assert made.y is not None
    ax.patch.set(**HATCH)
    whole = bool(np.isfinite(z).all())
    values = np.ma.masked_invalid(z)
    low, high = _limits(z)
    dx, dy = (0.5 * (a[1] - a[0]) for a in (made.xs, made.ys))
    shown = ax.imshow(
        values, cmap=COLOURS, vmin=low, vmax=high, origin="lower", aspect="auto",
        extent=(made.xs[0] - dx, made.xs[-1] + dx, made.ys[0] - dy, made.ys[-1] + dy),
        interpolation="bilinear" if whole else "nearest", interpolation_stage="data",
    )  # fmt: skip
    _contours(ax, made, values, _levels(z))
    if not whole:
        _say_gaps(ax, made, output)
    ax.set_xlabel(labelled(made.x), fontsize=9)
    ax.set_ylabel(labelled(made.y), fontsize=9)
    ax.set(xlim=(made.xs[0], made.xs[-1]), ylim=(made.ys[0], made.ys[-1]))
    ticks(ax.xaxis, ax.yaxis)
    return shown


def _contours(ax: Axes, made: Surface, values: Any, levels: np.ndarray) -> None:
    """White lines with a dark edge, to be seen on every colour, each level with its number."""
    from matplotlib.patheffects import withStroke

    if not levels.size:
        return
    lines = ax.contour(made.xs, made.ys, values, levels=levels, colors="white", linewidths=0.8, linestyles="-")
    lines.set(path_effects=[withStroke(linewidth=1.6, foreground="0.2")])
    corner = np.array([made.xs[0], made.ys[0]])
    size = np.array([made.xs[-1], made.ys[-1]]) - corner
    ways = [(np.asarray(path.vertices) - corner) / size for path in lines.get_paths()]
    for level, place in zip(levels, label_places(ways), strict=True):
        if place is None:
            continue
        x, y = corner + size * place
        ax.text(x, y, number(float(level), 6), fontsize=SMALL, color="white", ha="center", va="center",
                path_effects=[withStroke(linewidth=2.6, foreground="0.2")])  # fmt: skip


def label_places(ways: list[np.ndarray]) -> list[np.ndarray | None]:
    """A point on each line, on the unit square, where its number fits: not at the edge, away from the others."""
    found: list[np.ndarray | None] = []
    for way in ways:
        inner = way[((way > 0.05) & (way < 0.95)).all(axis=1)]
        taken = [p for p in found if p is not None]
        if not inner.size:
            found.append(None)
            continue
        # a number is wider than high: distances across count less
        apart = [np.hypot(*((inner - p) * (0.6, 1.0)).T) for p in taken]
        free = np.min(apart, axis=0) if apart else np.full(len(inner), 1.0)
        best = int(np.argmax(np.minimum(free, 0.15) - 0.2 * np.hypot(*(inner - 0.5).T)))
        found.append(inner[best] if free[best] > 0.05 else None)
    return found


def _relief(ax: Any, made: Surface, output: Output, z: np.ndarray) -> Any:
    """The surface in three dimensions; None where it has no value anywhere."""
    assert made.y is not None
    every = max(1, math.ceil(len(made.xs) / FACES))
    pick = np.unique(np.append(np.arange(0, len(made.xs), every), len(made.xs) - 1))
    x, y = np.meshgrid(made.xs[pick], made.ys[pick])
    part = z[np.ix_(pick, pick)]
    known = part[np.isfinite(part)]
    if known.size == 0:
        ax.set_axis_off()
        return None
    low, high = _limits(z)
    shown = ax.plot_surface(
        x, y, np.ma.masked_invalid(part), cmap=COLOURS, vmin=low, vmax=high,
        rcount=len(pick), ccount=len(pick), linewidth=0.15, edgecolor=(0, 0, 0, 0.25), rasterized=True,
    )  # fmt: skip
    for axis, variable, pad in ((ax.xaxis, made.x, 1), (ax.yaxis, made.y, 1), (ax.zaxis, output, 2)):
        axis.set_label_text(labelled(variable, 24), fontsize=9)
        ticks(axis, count=5)
        # numbers are centred where they stand, so wide ones need more room
        wide = max((len(number(float(v), 6)) for v in axis.get_majorticklocs()), default=0)
        pad += 2 * max(0, wide - 5)
        axis.set_tick_params(pad=pad - 1)
        axis.labelpad = pad
    ax.view_init(elev=28, azim=_azimuth(part))
    ax.set_box_aspect((4, 4, 3), zoom=1.04)
    ax.patch.set_visible(False)  # its labels reach beyond its frame, into what would be margins
    ax.set_in_layout(False)
    return shown


def _azimuth(z: np.ndarray) -> float:
    """From where the slope is seen in profile: across the diagonal along which the surface rises or falls."""
    known = z[np.isfinite(z)]
    size = float(known.max() - known.min()) or 1.0
    along_x, along_y = (np.diff(z, axis=a) / size for a in (1, 0))
    means = [float(np.nanmean(d)) if np.isfinite(d).any() else 0.0 for d in (along_x, along_y)]
    return -55.0 if means[0] * means[1] > 0.0 else -125.0
