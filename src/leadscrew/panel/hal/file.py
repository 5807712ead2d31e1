"""The file that says what the panel shows of a HAL and what it may write: TOML, ``kind = "hal"``."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, PrivateAttr, model_validator

from leadscrew.file_schema import Finite, Table, validated
from leadscrew.kernel.parameters import nearest
from leadscrew.util import reading
from leadscrew.util.errors import DataError

MOST_SIGNALS = 20
"""That one FIFO of sampler takes."""
LONGEST_RAMP_S = 10.0
"""Of a parameter with a ``rate``, from one bound to the other: leaving must not take longer."""
HalName = Annotated[str, Field(pattern=r"^[A-Za-z0-9_][A-Za-z0-9_.:+-]{0,46}$")]
"""Of a pin, parameter or signal; HAL allows 47 characters."""
Role = Literal["command", "feedback", "actual", "error", "output", "disturbance", "other"]


class Signal(Table):
    """What is sampled: a signal of HAL, or a pin."""

    source: HalName
    label: Annotated[str, Field(min_length=1, max_length=60)]
    unit: Annotated[str, Field(max_length=20)] = ""
    """Of the number in HAL."""
    role: Role = "other"
    factor: Finite = 1.0
    """From the number in HAL to the number that is shown."""
    shown_unit: Annotated[str, Field(max_length=20)] = ""
    """After the factor; empty: ``unit``."""

    @property
    def shown(self) -> str:
        """The unit of what is shown."""
        return self.shown_unit or self.unit


class Parameter(Table):
    """What may be written: an input pin that nothing drives, or a parameter that HAL says may be written."""

    key: Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_.-]{0,63}$")]
    hal: HalName
    low: Finite
    high: Finite
    unit: Annotated[str, Field(max_length=20)] = ""
    help: Annotated[str, Field(max_length=300)] = ""
    safe: Finite | None = None
    """What it returns to; none: as it was read at attaching."""
    type: Literal["float", "int"] = "float"
    rate: Annotated[float, Field(gt=0, allow_inf_nan=False)] | None = None
    """Largest change, unit per second; none: at once."""

    @model_validator(mode="after")
    def _sound(self) -> Parameter:
        if not self.low < self.high:
            raise ValueError(f"low = {self.low:g} is not below high = {self.high:g}")
        if self.safe is not None and not self.low <= self.safe <= self.high:
            raise ValueError(f"safe = {self.safe:g} is not in [{self.low:g}, {self.high:g}]")
        if self.type == "int":
            for name in ("low", "high", "safe"):
                value = getattr(self, name)
                if value is not None and (value != math.floor(value) or abs(value) > 2**32):
                    raise ValueError(f"{name} = {value:g}: expected a whole number, as type = 'int' says")
            if self.rate is not None:
                raise ValueError("rate is for type = 'float' only")
        if self.rate is not None and (self.high - self.low) / self.rate > LONGEST_RAMP_S:
            slowest = (self.high - self.low) / LONGEST_RAMP_S
            raise ValueError(f"rate = {self.rate:g} takes more than {LONGEST_RAMP_S:g} s from low to high: "
                             f"give {slowest:g} or more")  # fmt: skip
        return self


class Band(Table):
    """A tolerance drawn in a plot, in the shown unit."""

    low: Finite
    high: Finite
    label: str = ""
    about: HalName | Literal[""] = ""
    """The source that it lies about; empty: zero."""


class Plot(Table):
    """A plot of some signals."""

    title: Annotated[str, Field(min_length=1, max_length=60)]
    sources: Annotated[list[HalName], Field(min_length=1)]
    bands: list[Band] = Field(default_factory=list)


class HalFile(Table):
    """The keys of the file."""

    schema_version: Literal[1]
    kind: Literal["hal"]
    name: Annotated[str, Field(min_length=1, max_length=60)]
    thread: HalName | Literal[""] = ""
    """That it is sampled in; may be left out where HAL has one only."""
    period_s: Annotated[float, Field(gt=0, lt=1, allow_inf_nan=False)] = 1e-3
    """Of this thread; checked against HAL."""
    window_s: Annotated[float, Field(ge=0.5, le=600, allow_inf_nan=False)] = 10.0
    """Width of the plots."""
    buffer_s: Annotated[float, Field(ge=0.5, le=60, allow_inf_nan=False)] = 4.0
    """What sampler's FIFO holds before samples are lost."""
    on_leave: Literal["safe", "keep"] = "safe"
    """What becomes of the written parameters when the panel ends."""
    writes_per_s: Annotated[float, Field(gt=0, le=100, allow_inf_nan=False)] = 20.0
    """Changes by the operator; more are refused."""
    signals: Annotated[list[Signal], Field(min_length=1, max_length=MOST_SIGNALS)]
    parameters: Annotated[list[Parameter], Field(max_length=100)] = Field(default_factory=list)
    plots: list[Plot] = Field(default_factory=list)
    _where: str = PrivateAttr("")

    @property
    def where(self) -> str:
        """What errors call the file."""
        return self._where or self.name

    @model_validator(mode="after")
    def _consistent(self) -> HalFile:
        for what, names in (
            ("signals: source", [s.source for s in self.signals]),
            ("parameters: key", [p.key for p in self.parameters]),
            ("parameters: hal", [p.hal for p in self.parameters]),
        ):
            twice = next((n for n in names if names.count(n) > 1), None)
            if twice is not None:
                raise ValueError(f"{what} = {twice!r} is there twice")
        units = {s.source: s.shown for s in self.signals}
        for plot in self.plots:
            bands = [b.about for b in plot.bands if b.about]
            for source in (*plot.sources, *bands):
                if source not in units:
                    raise ValueError(f"plot {plot.title!r} names {source!r}, which is not among the sources of "
                                     f"[[signals]]{nearest(source, list(units))}")  # fmt: skip
            shown = sorted({units[s] for s in plot.sources})
            if len(shown) > 1:
                raise ValueError(f"plot {plot.title!r} has signals in {', '.join(shown)}: one plot has one shown unit")
        return self


def read(path: str | Path) -> HalFile:
    """What stands in a file.

    Raises:
        DataError: no such file, no TOML, or a key that is missing, unknown or out of its range; names file and key.
    """
    where = Path(path)
    return parsed(reading.text(where, reading.SETTINGS, "settings"), str(where))


def parsed(text: str, where: str) -> HalFile:
    """What stands in the text of a file that is called ``where`` in errors.

    Raises:
        DataError: see :func:`read`.
    """
    table = reading.toml_of(text, where)
    if table.get("kind") != "hal":
        raise DataError(f"{where}: kind = {table.get('kind')!r}: expected kind = 'hal'")
    found = validated(HalFile, table, where)
    found._where = where
    return found
