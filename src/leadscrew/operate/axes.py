"""One live loop, or two on a circle, that advance together, with what is still to be set in them."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.kernel.live import Live
from leadscrew.kernel.loop import DivergenceWarning
from leadscrew.kernel.parameters import nearest
from leadscrew.operate import integrators
from leadscrew.util.errors import NameUnknown

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

PREFIXES = ("x.", "y.")
"""Of the keys of one axis alone; a key without prefix means both."""

Packed = tuple["Loop", tuple[np.ndarray, np.ndarray]]


@dataclass(frozen=True)
class Later:
    """Values to be set as soon as ``period`` periods are done: a step of a ramp, or the end of a pulse."""

    period: int
    parts: tuple[dict[str, Any], ...]
    """By axis, by dotted key."""
    why: str = ""
    """Of a scheduled change; empty for a step of a change made by hand."""
    scaled: tuple[dict[str, float], ...] = ()
    """By axis: by what numbers of the controller's state are multiplied then, by their keys."""

    @property
    def scheduled(self) -> bool:
        """Whether it is a change of its own, and no step of one."""
        return bool(self.why)


class Axes:
    """Live loops side by side: rows of all their columns, at full rate."""

    def __init__(self, lives: list[Live]) -> None:
        self.lives = lives
        self.pending: list[Later] = []
        self.period = lives[0].period
        self.period_s = lives[0].loop.period
        loop = lives[0].loop
        self._roots = list(dict.fromkeys(c.split(".")[0] for c in loop.program.plan.columns if c != "time"))
        own = loop.columns(self._roots)
        self.columns = own + [f"y.{c}" for c in own[1:]] * (len(lives) - 1)
        self._width = len(own)

    @property
    def diverged(self) -> str:
        """Where a loop was lost, in words; empty while none is."""
        for i, live in enumerate(self.lives):
            if live.diverged is not None:
                return f"{'axis ' + PREFIXES[i][0] + ': ' if len(self.lives) > 1 else ''}{live.diverged}"
        return ""

    def fork(self) -> Axes:
        """The same place again, sharing no array: what happens to one does not reach the other."""
        lives = []
        for live in self.lives:
            other = Live(live.loop, live.engine, live.replicate)
            other.restore(live.save())
            other.diverged = live.diverged
            lives.append(other)
        new = Axes(lives)
        new.period, new.pending = self.period, list(self.pending)
        return new

    # ---- advancing
    def advance(self, periods: int) -> np.ndarray:
        """Rows of the next periods, fewer where a loop is lost; what is due on the way is set at its exact period."""
        parts, left = [], periods
        while left > 0 and not self.diverged:
            parts.append(self.piece(left))
            left -= len(parts[-1])
            self.due()
        return parts[0] if len(parts) == 1 else np.concatenate([np.zeros((0, len(self.columns))), *parts])

    def piece(self, periods: int) -> np.ndarray:
        """Rows up to where something is due, ``periods`` at most; the caller then makes what is due."""
        n = min(periods, self.pending[0].period - self.period) if self.pending else periods
        found = []
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DivergenceWarning)
            for live in self.lives:
                found.append(np.array(list(live.advance(n, record=self._roots).signals.values())))
        rows = min(f.shape[1] for f in found)
        self.period += rows
        whole = np.empty((rows, len(self.columns)))
        whole[:, : self._width] = found[0][:, :rows].T
        if len(found) > 1:
            whole[:, self._width :] = found[1][1:, :rows].T
        return whole

    def due(self, done: Callable[[Later], None] | None = None) -> None:
        """Sets what is due now."""
        while self.pending and self.pending[0].period <= self.period and not self.diverged:
            later = self.pending.pop(0)
            if later.scheduled:
                self.forget(list(later.parts))
            self.take(self.moved(list(later.parts)))
            for live, by in zip(self.lives, later.scaled, strict=False):
                integrators.scale(live, by)
            if done is not None and later.scheduled:
                done(later)

    def later(self, later: Later) -> None:
        """Remembers values to be set, in the order of their periods."""
        at = next((i for i, x in enumerate(self.pending) if x.period > later.period), len(self.pending))
        self.pending.insert(at, later)

    def forget(self, parts: list[dict[str, Any]]) -> None:
        """A new value for a key cancels what was still to come for it, and what a step would have rescaled with it."""
        if not self.pending:
            return
        kept = []
        for x in self.pending:
            left = tuple(
                {k: v for k, v in was.items() if k not in now} for was, now in zip(x.parts, parts, strict=True)
            )
            if any(left):
                whole = zip(x.scaled, left, x.parts, strict=False)
                kept.append(replace(x, parts=left, scaled=tuple(by if own == was else {} for by, own, was in whole)))
        self.pending = kept

    # ---- parameters
    def split(self, changes: Mapping[str, Any]) -> list[dict[str, Any]]:
        """The changes of each axis: keys without prefix are those of all.

        Raises:
            NameUnknown: no such parameter.
        """
        return split(changes, self.lives[0].loop.sheet, len(self.lives))

    def joined(self, parts: tuple[dict[str, Any], ...] | list[dict[str, Any]]) -> dict[str, Any]:
        """One mapping for the changes of each axis; the reverse of :meth:`split`."""
        if len(parts) == 1:
            return dict(parts[0])
        x, y = parts
        both = {k: v for k, v in x.items() if k in y and np.array_equal(y[k], v)}
        return {
            **both,
            **{f"x.{k}": v for k, v in x.items() if k not in both},
            **{f"y.{k}": v for k, v in y.items() if k not in both},
        }

    def named(self, parts: list[dict[str, Any]]) -> dict[str, Any]:
        """Values of each axis in one mapping: the first axis's plain, the second's behind its prefix."""
        return {**parts[0], **{f"y.{k}": v for k, v in parts[-1].items()}} if len(parts) > 1 else dict(parts[0])

    def values(self, ended: bool = False) -> list[dict[str, Any]]:
        """Every parameter of each axis; one that is on a ramp with the value that it goes to.

        ``ended``: as they will be when everything that was scheduled is over.
        """
        found = [dict(live.loop.parameters) for live in self.lives]
        for later in self.pending:
            if ended or not later.scheduled:
                for values, part in zip(found, later.parts, strict=True):
                    values.update(part)
        return found

    def moved(self, parts: list[dict[str, Any]]) -> list[Packed]:
        """The loops with these changes, and their parameters as the programs take them; nothing is changed yet.

        Raises:
            NameUnknown, ValueRefused: as ``Live.changed``.
        """
        return [live.changed(part) for live, part in zip(self.lives, parts, strict=True)]

    def take(self, moved: list[Packed]) -> None:
        """Sets what :meth:`moved` gave, in all axes."""
        for live, (loop, params) in zip(self.lives, moved, strict=True):
            live.loop, live.params = loop, params


def split(changes: Mapping[str, Any], known: Mapping[str, Any], axes: int) -> list[dict[str, Any]]:
    """Changes by axis; see :meth:`Axes.split`."""
    parts: list[dict[str, Any]] = [{} for _ in range(axes)]
    for key, value in changes.items():
        axis = PREFIXES.index(key[:2]) if axes > 1 and key[:2] in PREFIXES else None
        own = key if axis is None else key[2:]
        if own not in known:
            raise NameUnknown(f"there is no parameter {key!r}{nearest(own, list(known))}")
        for i, part in enumerate(parts):
            if axis in (None, i):
                part[own] = value
    return parts


__all__ = ["PREFIXES", "Axes", "Later", "split"]
