"""What an operator sees of a machine and how the machine can be disturbed: plots, tolerance bands, disturbances.

A profile is data about one study; the studies' own profiles lie in :mod:`leadscrew.operate.profiles`, one file each,
and :func:`~leadscrew.operate.profiles.profile_of` gives one for every other study, machine file or loop as well.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

from leadscrew.figures.signals import column_units, compared_column, factor_between
from leadscrew.kernel.parameters import nearest
from leadscrew.util.errors import NameUnknown, ValueRefused

if TYPE_CHECKING:
    from leadscrew.kernel.block import Block
    from leadscrew.kernel.loop import Loop

Role = Literal["command", "feedback", "actual", "error", "output", "disturbance", "other"]

Changes = list[tuple[float, dict[str, Any]]]
"""What a disturbance does: (seconds from now, parameters by dotted key), the first at 0 s."""


@dataclass(frozen=True)
class Trace:
    """One line of a plot: a column of the loop times ``factor``, shown in ``unit``.

    ``signal``: of a command, feedback or error with several numbers the one that is compared. :func:`fitted` fills in
    ``unit``, the plot's, and ``factor``, from the units of column and plot, where it is not given (NaN). No block knows
    the unit of a load.
    """

    signal: str
    label: str
    role: Role
    factor: float = math.nan
    unit: str = ""


@dataclass(frozen=True)
class Band:
    """A tolerance drawn behind the lines, in the shown unit; around zero, or around a column of the loop.

    ``label`` is short enough to stand beside the plot's title; ``doc`` says in full whose tolerance it is.
    """

    low: float
    high: float
    label: str
    about: str = ""
    doc: str = ""


@dataclass(frozen=True)
class Plot:
    """Lines over one time axis, all in one unit."""

    title: str
    unit: str
    traces: tuple[Trace, ...]
    bands: tuple[Band, ...] = ()


@dataclass(frozen=True)
class Readout:
    """A number that the operator reads at a glance: a column of the loop, or a parameter by its key, times ``factor``.

    ``source`` and ``factor`` as of a :class:`Trace`. ``per``: a column or parameter that it is divided by.
    ``decimals``: None where the size of the number says how many. ``shows``: of what came since the last showing (a
    quarter of a second) the mean, or the value that is farthest from 0, which a mean would hide where a signal swings.
    Several of one label: the first that the loop has.
    """

    label: str
    source: str
    unit: str
    decimals: int | None = None
    per: str = ""
    shows: Literal["mean", "peak"] = "mean"
    factor: float = math.nan


@dataclass(frozen=True)
class Field:
    """A number that the operator gives with a disturbance, within ``low`` and ``high``."""

    name: str
    label: str
    unit: str
    low: float
    high: float
    value: float
    doc: str

    def check(self, value: Any) -> float:
        """``value`` as a number within the bounds.

        Raises:
            ValueRefused: no number, not finite, or out of bounds.
        """
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ValueRefused(f"{self.name} = {value!r}: expected a number{' in ' + self.unit if self.unit else ''}")
        if not self.low <= value <= self.high:
            unit = f" {self.unit}" if self.unit else ""
            raise ValueRefused(f"{self.name} = {value!r}: allowed range is [{self.low:g}, {self.high:g}]{unit}")
        return float(value)


@dataclass(frozen=True)
class Disturbance:
    """Something done to the running machine by setting parameters, at once and later.

    ``act(fields, now_s, values)`` gives the changes for checked fields, the simulated time of the next period and the
    loop's parameters by dotted key, as they will be when every end that is still to come has come: a pulse during a
    pulse ends at what was before both. ``needs`` are the keys that it cannot do without: a loop that lacks one cannot
    be disturbed in this way.
    """

    name: str
    label: str
    doc: str
    fields: tuple[Field, ...]
    act: Callable[[Mapping[str, float], float, Mapping[str, Any]], Changes]
    needs: tuple[str, ...] = ()

    def changes(self, fields: Mapping[str, Any], now_s: float, values: Mapping[str, Any]) -> Changes:
        """What ``act`` gives for fields that were checked; a field that is not given has its default.

        Raises:
            NameUnknown: no such field.
            ValueRefused: a value out of the bounds of its field.
        """
        known = {field.name: field for field in self.fields}
        for name in fields:
            if name not in known:
                raise NameUnknown(f"{self.name} has no field {name!r}{nearest(name, list(known))}")
        checked = {name: field.check(fields.get(name, field.value)) for name, field in known.items()}
        return self.act(checked, now_s, values)


def untouched(loop: Loop) -> Loop:
    """The loop as it is."""
    return loop


@dataclass(frozen=True)
class Profile:
    """How one machine is operated.

    ``study``, ``controller``, ``scenario`` are what the panel starts with (both None for a loop of one's own).
    ``operated`` puts quiet blocks into free places of the loop; nobody touching them, its signals have the same bits.
    ``circle``: two axes on one circle are worth a ball bar. ``readouts``: the numbers above the plots, at most six;
    none: the values of the first lines drawn. ``notes``: what happens when the command ends, and what
    cannot change in the run.
    """

    study: str
    controller: str | None
    scenario: str | None
    window_s: float
    plots: tuple[Plot, ...]
    disturbances: tuple[Disturbance, ...] = ()
    operated: Callable[[Loop], Loop] = untouched
    circle: bool = False
    notes: str = ""
    readouts: tuple[Readout, ...] = ()

    def disturbance(self, name: str) -> Disturbance:
        """The disturbance of that name.

        Raises:
            NameUnknown: this machine has none of that name.
        """
        known = {d.name: d for d in self.disturbances}
        if name not in known:
            raise NameUnknown(f"there is no disturbance {name!r}{nearest(name, list(known))}")
        return known[name]


def fitted(profile: Profile, loop: Loop) -> Profile:
    """The profile with the columns and factors of ``loop``, without what it has no signals or parameters for.

    ``loop`` is the operated one: what ``profile.operated`` puts in counts.
    """
    units, keys = column_units(loop), loop.sheet

    def column(name: str) -> str:
        return name if not name or name in units or name in keys else compared_column(loop, name)

    def factor(known: float, source: str, shown: str) -> float:
        own = units[source] if source in units else keys[source].unit
        return factor_between(own, shown) if math.isnan(known) else known

    plots = []
    for plot in profile.plots:
        traces = tuple(
            replace(t, signal=signal, factor=factor(t.factor, signal, plot.unit), unit=plot.unit)
            for t in plot.traces if (signal := column(t.signal)) in units
        )  # fmt: skip
        bands = (replace(b, about=column(b.about)) for b in plot.bands)
        if traces:
            plots.append(replace(plot, traces=traces, bands=tuple(b for b in bands if not b.about or b.about in units)))
    kept = tuple(d for d in profile.disturbances if all(key in keys for key in d.needs))
    shown: dict[str, Readout] = {}
    for readout in profile.readouts:
        source, per = column(readout.source), column(readout.per)
        if all(not name or name in units or name in keys for name in (source, per)):
            filled = replace(readout, source=source, per=per, factor=factor(readout.factor, source, readout.unit))
            shown.setdefault(readout.label, filled)
    return replace(profile, plots=tuple(plots), disturbances=kept, readouts=tuple(shown.values()))


NEVER_S = 1e9
"""Length of a pulse that stays, in a block that ends its pulses itself."""

LONGEST_S = 600.0

Values = Mapping[str, Any]


def with_blocks(loop: Loop, **blocks: Block) -> Loop:
    """The loop with other blocks in the slots named; everything else, the origin too, as it is."""
    new = copy.copy(loop)
    known = ("program", "sheet", "signals", "module")
    new.__dict__ = {k: v for k, v in loop.__dict__.items() if k not in known}
    new.blocks = {**loop.blocks, **blocks}
    return new


def with_pulse(loop: Loop) -> Loop:
    """The loop with a load pulse of size 0 where nothing loads it."""
    from leadscrew.disturbances._pulse_load import pulse_load

    if loop.blocks["disturbance"] is not None:
        return loop
    return with_blocks(loop, disturbance=pulse_load(size=0.0))


def lasting(value: float = 1.0) -> Field:
    """The field that says for how long."""
    return Field("for_s", "for", "s", 0.0, LONGEST_S, value, "how long it lasts; 0: it stays")


def for_a_while(changes: dict[str, Any], values: Values, seconds: float) -> Changes:
    """The changes now, and the values before them after ``seconds``; 0: they stay."""
    if seconds <= 0.0:
        return [(0.0, changes)]
    return [(0.0, changes), (seconds, {key: values[key] for key in changes})]


def axis_plots(machine: str, *bands: Band) -> tuple[Plot, Plot]:
    """Position in mm and error in um of an axis; ``machine``: what moves, for the labels; ``bands`` of the error."""
    position = (
        Trace("command", "command", "command"), Trace("actual", machine, "actual"),
        Trace("feedback", "reading", "feedback"),
    )  # fmt: skip
    error = (
        Trace("true_error", f"error of the {machine}", "error"), Trace("error", "error as measured", "other")
    )  # fmt: skip
    return Plot("Position", "mm", position), Plot("Error", "um", error, bands)


def load_pulse(
    unit: str,
    most: float,
    value: float,
    doc: str,
    *,
    at: str = "disturbance",
    factor: float = 1.0,
    label: str = "Load pulse",
    lasts_s: float = 0.2,
    least: float | None = None,
) -> Disturbance:
    """A pulse of the block ``pulse_load`` at the keys ``at.*``; ``factor``: from the shown unit to the load's."""

    def act(fields: Mapping[str, float], now_s: float, values: Values) -> Changes:
        size, seconds = factor * fields["size"], fields["for_s"]
        return [(0.0, {f"{at}.size": size, f"{at}.start": now_s, f"{at}.duration": seconds or NEVER_S})]

    size = Field("size", "size", unit, -most if least is None else least, most, value, "size of the pulse; 0 ends one")
    keys = (f"{at}.size", f"{at}.start", f"{at}.duration")
    return Disturbance("load_pulse", label, doc, (size, lasting(lasts_s)), act, keys)


def to_value(
    name: str, label: str, doc: str, key: str, field: Field, *, factor: float = 1.0, lasts_s: float | None = None
) -> Disturbance:
    """One parameter to ``factor`` times the field's number, for a while or (``lasts_s`` None) for good."""

    def act(fields: Mapping[str, float], now_s: float, values: Values) -> Changes:
        return for_a_while({key: factor * fields[field.name]}, values, fields.get("for_s", 0.0))

    fields = (field,) if lasts_s is None else (field, lasting(lasts_s))
    return Disturbance(name, label, doc, fields, act, (key,))


def multiplied(
    name: str,
    label: str,
    doc: str,
    keys: tuple[str, ...],
    field: Field,
    *,
    times: Callable[[float], float] = float,
    lasts_s: float = 2.0,
) -> Disturbance:
    """All of ``keys`` times the same number, for a while; ``times``: from the field's number to the factor."""

    def act(fields: Mapping[str, float], now_s: float, values: Values) -> Changes:
        by = times(fields[field.name])
        return for_a_while({key: by * values[key] for key in keys}, values, fields["for_s"])

    return Disturbance(name, label, doc, (field, lasting(lasts_s)), act, keys)


def moved_on(origin: str, start: str, target: Field, more: tuple[str, ...] = ()) -> Disturbance:
    """A new move of a reference that goes ``reference.distance`` from ``origin`` at the time ``start``.

    It goes on from where the last move ends; one that has not ended is cut short, and the command jumps there.
    ``more``: keys by which the reference is told from others.
    """
    distance = "reference.distance"

    def act(fields: Mapping[str, float], now_s: float, values: Values) -> Changes:
        end = values[origin] + values[distance]
        return [(0.0, {origin: end, distance: fields["target"] - end, start: now_s})]

    doc = "A new move like the last one, from its end, for this axis and for the one it is compared with."
    return Disturbance("move_to", "Move to", doc, (target,), act, (origin, distance, start, *more))


def noise(
    key: str, unit: str, most: float, value: float, what: str, *, factor: float = 1.0, lasts_s: float = 2.0
) -> Disturbance:
    """More noise of the sensor: the standard deviation of one reading at ``key``."""
    field = Field("deviation", "deviation", unit, 0.0, most, value, f"standard deviation of one reading of {what}")
    doc = f"Noise of {what}: white and Gaussian, one value for each control period."
    return to_value("noise", "Noise", doc, key, field, factor=factor, lasts_s=lasts_s)
