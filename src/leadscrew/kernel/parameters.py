"""Data sheets: the unit, bounds and help of a parameter, read from its annotation and checked at the validate."""

from __future__ import annotations

import difflib
import math
import typing
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

from annotated_types import Ge, Gt, Interval, Le, Lt, Unit

from leadscrew.util.errors import NameUnknown, ValueRefused

__all__ = ["Choice", "Doc", "Ge", "Gt", "Le", "Lt", "ParameterSpec", "Unit", "checked_replace", "entries", "nearest"]


@dataclass(frozen=True)
class Doc:
    """One sentence of help, inside an annotation."""

    text: str


@dataclass(frozen=True)
class Choice:
    """The options of a parameter annotated ``Literal["sine", "square"] | int``: blocks compute with their numbers."""

    names: tuple[str, ...]

    def number(self, value: Any) -> int | None:
        """The number of a name, from 0; of a number, as files of 0.1.0 and arrays have it, itself. None: there is none.

        A choice of off and on takes true and false too.
        """
        import numpy as np

        if isinstance(value, bool | np.bool_):
            value = "on" if value else "off"
        if isinstance(value, str):
            return self.names.index(value) if value in self.names else None
        return int(value) if isinstance(value, int | float | np.number) and value in range(len(self.names)) else None

    def __str__(self) -> str:
        """The names with their numbers, for C and HAL."""
        return ", ".join(f"{number} {name}" for number, name in enumerate(self.names))


@dataclass(frozen=True)
class ParameterSpec:
    """One leaf of a data sheet."""

    key: str
    type: str
    """``float``, ``int``, ``bool``, ``array`` or ``choice``."""
    default: Any
    """Of a choice the name."""
    unit: str = ""
    doc: str = ""
    above: float = -math.inf
    below: float = math.inf
    above_open: bool = False
    below_open: bool = False
    choice: Choice | None = None

    @property
    def range(self) -> str:
        """The allowed range in interval notation, or the names of a choice; empty where there is none."""
        if self.choice is not None:
            return ", ".join(self.choice.names)
        if self.above == -math.inf and self.below == math.inf:
            return ""
        low = "(" if self.above_open or self.above == -math.inf else "["
        high = ")" if self.below_open or self.below == math.inf else "]"
        return f"{low}{self.above:g}, {self.below:g}{high}"

    def check(self, value: Any, where: str = "") -> Any:
        """``value`` as this entry's type, of a choice its name.

        Raises:
            ValueRefused: wrong type, NaN, out of range, or no such name; the text names value, range and place.
        """
        import numpy as np

        place = f" ({where})" if where else ""
        plain = self.type == "array" and isinstance(value, np.ndarray)
        label = self.key + place if plain else f"{self.key} = {value!r}{place}"
        unit = f" {self.unit}" if self.unit else ""
        if self.choice is not None:
            number = self.choice.number(value)
            if number is None:
                close = difflib.get_close_matches(value, self.choice.names, 1, 0.4) if isinstance(value, str) else []
                hint = f"; did you mean {close[0]}?" if close else ""
                raise ValueRefused(f"{label}: there are {self.range}{hint}")
            return self.choice.names[number]
        if self.type == "array":
            try:
                array = np.array(value, dtype=np.float64)
            except (TypeError, ValueError):
                raise ValueRefused(f"{label}: expected an array of numbers") from None
            shape = np.shape(self.default)
            if array.shape != shape:
                raise ValueRefused(f"{self.key}{place}: expected an array of shape {shape}, got {array.shape}")
            if not np.isfinite(array).all():
                raise ValueRefused(f"{self.key}{place}: the array holds a value that is not finite")
            if self._refused(array).any():
                raise ValueRefused(f"{self.key} = {value!r}{place}: allowed range is {self.range}{unit}")
            return array
        elif self.type == "bool":
            if not isinstance(value, bool | np.bool_) and value not in (0, 1):
                raise ValueRefused(f"{label}: expected true or false")
            return bool(value)
        else:
            if isinstance(value, bool | str) or not isinstance(value, int | float | np.number):
                raise ValueRefused(f"{label}: expected a number{unit and ' in' + unit}{_unquoted(value)}")
            if isinstance(value, int) and abs(value) > 2**1023:
                raise ValueRefused(f"{self.key}{place}: a whole number of {len(str(abs(value)))} digits is too large")
            if math.isnan(value):
                raise ValueRefused(f"{label}: not a number (NaN) is not allowed")
            if self.type == "int":
                if value != int(value) if math.isfinite(value) else True:
                    raise ValueRefused(f"{label}: expected a whole number")
                if abs(value) > 2**53:  # type: ignore[operator]
                    raise ValueRefused(f"{label}: whole numbers beyond 2^53 cannot be carried exactly")
            if (
                math.isinf(value)
                and (self.above != -math.inf or self.below != math.inf)
                and not self._open_to(float(value))
            ):
                raise ValueRefused(f"{label}: allowed range is {self.range}{unit}")
            if self._refused(value):
                raise ValueRefused(f"{label}: allowed range is {self.range}{unit}")
        return int(value) if self.type == "int" else float(value)

    def stored(self, value: Any, where: str = "") -> Any:
        """``value``, checked, as the block computes with it: of a choice its number."""
        checked = self.check(value, where)
        return checked if self.choice is None else self.choice.number(checked)

    def _refused(self, value: Any) -> Any:
        """Where a number lies outside the range."""
        low = value <= self.above if self.above_open else value < self.above
        return low | (value >= self.below if self.below_open else value > self.below)

    def _open_to(self, value: float) -> bool:
        return (value > 0 and self.below == math.inf) or (value < 0 and self.above == -math.inf)


def _unquoted(value: Any) -> str:
    """What to write for a number that is given as a text."""
    try:
        return f"; write {float(value):g} without quotes" if isinstance(value, str) else ""
    except ValueError:
        return ""


def similar(name: str, known: Iterable[str]) -> list[str]:
    """The known name that is nearest, and up to two others that are about as near."""
    close = difflib.get_close_matches(name, known, n=3, cutoff=0.4)
    best = difflib.SequenceMatcher(None, close[0], name).ratio() if close else 0.0
    return difflib.get_close_matches(name, close, n=3, cutoff=0.9 * best)


def nearest(name: str, known: Mapping[str, Any] | list[str]) -> str:
    """A hint naming the nearest known names, for the end of an error text."""
    close = similar(name, list(known))
    if close:
        return f"; did you mean {', '.join(close)}?"
    return f"; known: {', '.join(list(known)[:12])}" if known else ""


@lru_cache(maxsize=2048)
def hints(cls: type) -> dict[str, Any]:
    """Annotations of a NamedTuple with their extras; empty ones where they cannot be resolved."""
    try:
        return typing.get_type_hints(cls, include_extras=True)
    except (NameError, TypeError):
        return dict(getattr(cls, "__annotations__", {}))


class Note(NamedTuple):
    """What an annotation says: its type, with the type's name, and the fields of an :class:`ParameterSpec`."""

    base: Any
    type: str
    found: dict[str, Any]


def note_of(hint: Any) -> Note:
    """What an annotation says."""
    base, *extras = typing.get_args(hint) if typing.get_origin(hint) is typing.Annotated else (hint,)
    found: dict[str, Any] = {}
    parts = (base,) if typing.get_origin(base) is typing.Literal else typing.get_args(base)
    names = [name for p in parts if typing.get_origin(p) is typing.Literal for name in typing.get_args(p)]
    if names:
        base, found["choice"] = int, Choice(tuple(names))
    for extra in extras:
        for part in extra if isinstance(extra, Interval) else (extra,):
            if isinstance(part, Unit):
                found["unit"] = part.unit
            elif isinstance(part, Doc):
                found["doc"] = part.text
            elif isinstance(part, Ge | Gt):
                found["above"] = float(part.ge if isinstance(part, Ge) else part.gt)  # type: ignore[arg-type]
                found["above_open"] = isinstance(part, Gt)
            elif isinstance(part, Le | Lt):
                found["below"] = float(part.le if isinstance(part, Le) else part.lt)  # type: ignore[arg-type]
                found["below_open"] = isinstance(part, Lt)
    return Note(base, base if isinstance(base, str) else getattr(base, "__name__", ""), found)


@lru_cache(maxsize=2048)
def notes(cls: type) -> dict[str, Note]:
    """What the annotations of a NamedTuple say, by field."""
    return {name: note_of(hint) for name, hint in hints(cls).items()}


SILENT = Note(None, "", {})


def leaf_type(note: Note, value: Any) -> str:
    """``float``, ``int``, ``bool`` or ``array`` from an annotation, or from the value where it says nothing."""
    import numpy as np

    if isinstance(value, np.ndarray | list) or note.type in ("ndarray", "NDArray"):
        return "array"
    if note.type in ("float", "int", "bool"):
        return note.type
    return "bool" if isinstance(value, bool) else "int" if isinstance(value, int) else "float"


def entries(value: Any, prefix: str = "") -> Iterator[ParameterSpec]:
    """Every leaf of a NamedTuple, nested ones under dotted keys, with what its annotation says."""
    if value is None:
        return
    cls: Any = type(value)
    sheet = notes(cls)
    for name, item in zip(value._fields, value, strict=True):
        key = f"{prefix}{name}"
        if isinstance(item, tuple) and hasattr(item, "_fields"):
            yield from entries(item, f"{key}.")
            continue
        note = sheet.get(name, SILENT)
        if (choice := note.found.get("choice")) is not None:
            number = choice.number(item)
            yield ParameterSpec(key, "choice", item if number is None else choice.names[number], **note.found)
        else:
            yield ParameterSpec(key, leaf_type(note, item), item, **note.found)


OLD_KEYS: Mapping[str, tuple[str, ...]] = {
    "most": ("max_offset", "max_feed", "max_speed", "max_shear"),
    "least": ("min_share",),
    "least_chip_mm": ("min_chip_mm",),
    "least_force": ("min_force",),
    "least_depth": ("min_depth",),
    "acts_late_s": ("actuation_delay_s",),
    "seen_late_s": ("measurement_delay_s",),
    "inputs_held": ("hold_inputs",),
}
"""Last parts of parameter keys of version 0.1.0, and what they may be called today."""


def renamed(changes: Mapping[str, Any], known: Mapping[str, Any]) -> dict[str, Any]:
    """The changes by the keys of today: the symmetric limit of version 0.1.0, 0 for none, gives both limits."""
    found: dict[str, Any] = {}
    for key, value in changes.items():
        head, point, last = key.rpartition(".")
        new = [f"{head}{point}{name}" for name in OLD_KEYS.get(last, ()) if f"{head}{point}{name}" in known]
        if key not in known and new:
            found[new[0]] = value
            continue
        ends = [f"{head}{point}{end}" for end in ("lower", "upper")]
        old = last in ("max_output", "max_torque") and key not in known and all(end in known for end in ends)
        if old and isinstance(value, int | float) and value >= 0.0:
            limit = float(value) or math.inf
            found |= dict(zip(ends, (-limit, limit), strict=True))
        else:
            found[key] = value
    return found


def checked_replace(value: Any, changes: Mapping[str, Any], where: str) -> Any:
    """``value`` with the dotted ``changes`` applied, each checked against its sheet.

    Raises:
        NameUnknown: a key that ``value`` does not have; names the nearest.
        ValueRefused: see :meth:`ParameterSpec.check`.
    """
    sheet = {e.key: e for e in entries(value)} if value is not None else {}
    for key, new in renamed(changes, sheet).items():
        if key not in sheet:
            raise NameUnknown(f"{where} has no parameter {key!r}{nearest(key, sheet)}")
        value = put(value, key.split("."), sheet[key].stored(new, where))
    return value


def put(value: Any, path: list[str], new: Any) -> Any:
    """``value`` with the field at ``path`` replaced, unchecked."""
    head, *rest = path
    return value._replace(**{head: put(getattr(value, head), rest, new) if rest else new})
