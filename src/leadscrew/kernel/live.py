"""A live loop: advanced a number of periods at a time, its parameters set between, saved and restored."""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.kernel import ieee, validate
from leadscrew.kernel.block import Block
from leadscrew.kernel.by_position import by_position
from leadscrew.kernel.engines import Entry
from leadscrew.kernel.frame import SLOTS
from leadscrew.kernel.linker import LARGEST, LIMITS
from leadscrew.kernel.notes import DivergenceWarning, warn_diverged
from leadscrew.kernel.run import Divergence, Metrics, Run
from leadscrew.util.errors import NameUnknown, ValueRefused, entry_point

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

MEMORY = 8 * 1024**3
"""Bytes of recorded signals above which a run is refused; record less, or every n-th period."""

SLICE_S, FIRST_SLICE = 0.1, 1000
"""Seconds of machine code between two looks at Ctrl-C, and the periods of the first slice."""


@dataclass(frozen=True)
class Saved:
    """Where a live loop stood: periods done, scalar state, array state, parameters."""

    period: int
    scalars: np.ndarray
    arrays: np.ndarray
    params: tuple[np.ndarray, np.ndarray]
    loop: Loop


@entry_point
class Live:
    """One loop in motion. Ten times ``advance(100)`` gives the same bits as ``advance(1000)``."""

    def __init__(self, loop: Loop, engine: str, replicate: int = 0, duration: float = math.inf) -> None:
        self.loop = loop
        self.duration = duration
        """Seconds after which the run ends; infinite where that is not known."""
        self.engine = engine
        self.replicate = validate.whole("replicate", replicate, 0, 2**31 - 1)
        self.program = loop.program
        self.entry = self.program.entry("single", engine)
        self.period = 0
        self.diverged: Divergence | None = None
        params, state = loop.values(duration)
        self.params = self.program.plan.params.pack(params)
        self.state = self.program.plan.state.pack(state)
        self._counters = np.zeros(6, dtype=np.int64)
        self._nothing = np.zeros(0, dtype=np.int64), np.zeros((1, 1))
        self._metrics = np.zeros((1, max(1, len(loop.metrics))))
        self._bound: tuple[tuple[np.ndarray, ...], Callable[[], int]] | None = None

    @property
    def time(self) -> float:
        """Simulated seconds so far."""
        return self.period * self.loop.period

    def values(self) -> dict[str, float]:
        """Every scalar of the state by its dotted key."""
        return {x.key: float(self.state[0][x.at]) for x in self.program.plan.state.scalars}

    def advance(self, periods: int, record: str | Sequence[str] | None = None, every: int = 1) -> Run:
        """Runs on for a number of periods and gives what was recorded on the way.

        Raises:
            ValueRefused: no whole positive number; a recording larger than memory allows.
            NameUnknown: no such signal.
        """
        periods = validate.whole("periods", periods, 1, 2**53)
        every = validate.whole("every", every, 0, 2**53)
        columns = self.loop.columns(record) if every else []
        rows = 0 if every == 0 else -(-(self.period + periods) // every) - -(-self.period // every)
        if rows * len(columns) * 8 > MEMORY:
            raise ValueRefused(
                f"recording {rows} rows of {len(columns)} signals needs {rows * len(columns) * 8 / 1e9:.0f} GB; "
                f"record fewer signals, or every={-(-rows * len(columns) * 8 // MEMORY) * max(1, every)}"
            )
        if columns:
            index = {c: i for i, c in enumerate(self.program.plan.columns)}
            select = np.array([index[c] for c in columns], dtype=np.int64)
            table = np.zeros((len(columns), max(1, rows)))
        else:
            select, table = self._nothing
        metrics = self._metrics
        counters = self._counters if not columns else np.zeros(6, dtype=np.int64)
        counters[:] = (self.period, self.period + periods, every, self.replicate, 0, 0)
        start = self.period
        began = time.perf_counter()
        if self.diverged is None:
            try:
                self._call(counters, select, table, metrics)
            finally:  # after Ctrl-C too: the state stands where the last slice ended
                self.period = int(counters[0])
        wall = time.perf_counter() - began
        if counters[5] and self.diverged is None:
            self.diverged = self._divergence()
            warn_diverged(f"{self.loop.name}: {self.diverged}")
        measured = metrics[0] if self.diverged is None else np.full_like(metrics[0], np.nan)
        signals = {c: table[i, : counters[4]] for i, c in enumerate(columns)}
        return Run(
            loop=self.loop, signals=signals, diverged=self.diverged, engine=self.engine, wall_s=wall,
            duration=self.time, start=start * self.loop.period, replicate=self.replicate, every=every,
            metrics=Metrics(zip(self.loop.metrics, measured.tolist(), strict=False)),
            explained=self._explained() if np.isnan(measured).any() else None,
        )  # fmt: skip

    def _explained(self) -> Callable[[list[str]], dict[str, str]]:
        """What says of metrics, by their names, why they have no value at this moment."""
        plan, blocks, end, packed = self.program.plan, self.loop.metrics, self.time, self.params
        scalars, arrays = (x.copy() for x in self.state)

        def reasons(names: list[str]) -> dict[str, str]:
            params, state = plan.params.unpack(*packed).metrics, plan.state.unpack(scalars, arrays).metrics
            return {
                k: explain(getattr(params, k), getattr(state, k), end)
                if (explain := blocks[k].no_value) is not None
                else "the metric gives no reason"
                for k in names
            }

        return reasons

    def _call(self, counters: np.ndarray, select: np.ndarray, table: np.ndarray, metrics: np.ndarray) -> None:
        arrays = (*self.params, *self.state, counters, select, table, metrics)
        if isinstance(self.entry, Entry):
            if self._bound is None or any(a is not b for a, b in zip(arrays, self._bound[0], strict=True)):
                self._bound = arrays, self.entry.bind(*arrays)
            self._in_slices(self._bound[1], counters)
            return
        if self.engine != "python":
            self.entry(*arrays)
            return
        (P, A), (S, B) = self.params, self.state
        ieee.lost.clear()
        scalars, counts = S.tolist(), counters.tolist()
        self.entry(P.tolist(), A, scalars, B, counts, select, table, metrics)
        S[:], counters[:] = scalars, counts

    def _in_slices(self, call: Callable[[], int], counters: np.ndarray) -> None:
        """Runs machine code to its end with a return to Python every tenth of a second, where Ctrl-C is heard."""
        end, periods = int(counters[1]), FIRST_SLICE
        while True:
            counters[1] = min(end, int(counters[0]) + periods)
            began = time.perf_counter()
            call()
            if counters[0] >= end or counters[5]:
                return
            took = max(time.perf_counter() - began, 1e-9)
            periods = max(1, int(periods * min(4.0, SLICE_S / took)))

    def _divergence(self) -> Divergence:
        plan = self.program.plan
        name, value, bound = "", float("nan"), None
        for leaf in plan.state.scalars:
            number = float(self.state[0][leaf.at])
            limit = LIMITS.get(leaf.kind)
            if limit is not None and leaf.key.split(".")[0] in SLOTS and not abs(number) <= limit:
                name, value = leaf.key, number
                bound = limit if leaf.kind == "int" else None
                break
        else:
            for leaf in plan.state.arrays:
                part = self.state[1][leaf.at : leaf.at + leaf.size]
                if not np.all(np.abs(part) <= LARGEST):
                    name, value = leaf.key, float(part[~(np.abs(part) <= LARGEST)][0])
                    break
            else:
                name = "actual" if self.loop.bound < LARGEST else "output"
                bound = self.loop.bound if name == "actual" else None
        place = (
            f"{ieee.lost['file']}:{ieee.lost['line']} ({ieee.lost['what']})"
            if self.engine == "python" and ieee.lost
            else ""
        )
        return Divergence(
            time=self.period * self.loop.period,
            period=self.period - 1,
            state=name,
            value=value,
            bound=bound,
            place=place,
        )

    def set(self, key: str, value: Any) -> None:
        """Changes a parameter in the running loop, from the next period on.

        Raises:
            NameUnknown, ValueRefused: as ``Loop.using``.
        """
        self.set_all({key: value})

    def set_all(self, changes: Mapping[str, Any]) -> None:
        """Changes parameters in the running loop by dotted key, from the next period on: all, or none where one is
        refused.

        Raises:
            NameUnknown, ValueRefused: as ``Loop.using``; a change of the loop's size.
        """
        self.loop, self.params = self.changed(changes)

    def changed(self, changes: Mapping[str, Any]) -> tuple[Loop, tuple[np.ndarray, np.ndarray]]:
        """The loop with these changes and its parameters as the program takes them; nothing is changed yet.

        Raises:
            NameUnknown, ValueRefused: as :meth:`set_all`.
        """
        for key in ("seed", "bound"):
            if key in changes:
                raise NameUnknown(f"{key} cannot change in a running loop")
        if not changes:
            return self.loop, self.params
        loop = self.loop.using(changes)
        if loop.__dict__.get("program") is not self.program:
            said = ", ".join(f"{k} = {v!r}" for k, v in changes.items())
            raise ValueRefused(f"{said} changes the size of the loop; start a new one")
        params, _ = loop.values(self.duration)
        return loop, self.program.plan.params.pack(params)

    def save(self) -> Saved:
        """Where the loop stands now."""
        P, A = self.params
        return Saved(self.period, self.state[0].copy(), self.state[1].copy(), (P.copy(), A.copy()), self.loop)

    def restore(self, saved: Saved) -> None:
        """Goes back to a saved place; running on from there gives the same bits as before."""
        if saved.scalars.shape != self.state[0].shape or saved.arrays.shape != self.state[1].shape:
            raise ValueRefused("the saved state belongs to a loop of another shape")
        self.period, self.loop = saved.period, saved.loop
        self.state = (saved.scalars.copy(), saved.arrays.copy())
        self.params = (saved.params[0].copy(), saved.params[1].copy())
        self.diverged = None

    def switch(self, controller: Block) -> Live:
        """The loop from here on under another controller, started bumplessly where it supplies ``align``.

        The new live loop has the same plant, sensor and reference state; ``bumpless`` says whether it was aligned.
        """
        loop = self.loop.using()
        for built in ("program", "signals", "module"):
            loop.__dict__.pop(built, None)
        loop.blocks["controller"] = controller
        loop.blocks["controller"] = controller = by_position(loop.blocks, loop.period)
        new = Live(loop, self.engine, self.replicate)
        old_state = self.program.plan.state.unpack(*self.state)
        params, fresh = loop.values()
        kept = {s: getattr(old_state, s) for s in fresh._fields if s not in ("controller", "metrics")}
        new.bumpless = controller.align is not None
        if controller.align is not None:
            last = self.advance_preview()
            kept["controller"] = controller.align(params.controller, last["command"], last["feedback"], last["output"])
        new.state = new.program.plan.state.pack(fresh._replace(**kept))
        new.period = self.period
        return new

    def advance_preview(self) -> dict[str, Any]:
        """Command, feedback and output that the next period would have, without moving."""
        saved = self.save()
        diverged = self.diverged
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DivergenceWarning)
            seen = self.advance(1, record=("command", "feedback", "output"))
        self.restore(saved)
        self.diverged = diverged
        return {k: seen.signal(k, self.loop.signals[k]) for k in ("command", "feedback", "output")}

    bumpless: bool = False
    """Whether the controller was aligned to the one before it."""


__all__ = ["Live", "Saved"]
