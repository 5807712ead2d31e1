"""The runs of a simulated machine: built beside, kept to wall time, held, stopped and begun again."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from leadscrew.kernel.errors import DataError, ValueRefused
from leadscrew.operate.axes import PREFIXES
from leadscrew.operate.operated import Operated, Start
from leadscrew.operate.profile import Profile, fitted
from leadscrew.operate.profiles import profile_of
from leadscrew.panel import describing, taking
from leadscrew.panel.figures import Figures
from leadscrew.panel.frames import GHOST, LIVE, Frame, Thinner
from leadscrew.panel.machine import Later
from leadscrew.panel.pacing import FASTEST, SLOWEST, Pacer
from leadscrew.panel.plain import plain
from leadscrew.panel.records import Records
from leadscrew.panel.whys import Whys

Made = tuple[Operated, Profile, Whys]


class SimRun:
    """One simulated machine at a time; another study, scenario or run takes its place here.

    ``begin``, ``describe``, ``tick``, ``news``, ``why``, ``fail`` and ``close`` are those of a :class:`Machine`.
    """

    def __init__(
        self, start: Start, folder: Path, run: int = 0, named: Sequence[str] = (), own: Sequence[str] = ()
    ) -> None:
        self.first, self.folder, self.run = start, folder, run
        self.named, self.own = tuple(named), tuple(own)
        self.columns: list[str] = []
        self.running = "building"
        self.message = ""
        self._broken = self._pending = False
        self.taking = taking.Taking(folder / "captures")
        self.records = Records(folder)
        self._operated: Operated | None = None
        self._profile: Profile | None = None
        self._next = "stopped"
        self._touched: set[str] = set()
        self._told: dict[str, Any] = {}
        self._defaults: dict[str, Any] = {}
        """Of what runs after a stop or reset began with another value of."""
        self._compare = "previous"
        self._news: list[tuple[str, dict[str, Any]]] = []
        self.pacer = Pacer(1e-3)

    def begin(self) -> Later:
        """Builds the first machine."""
        return self._build(self.first)

    def describe(self) -> dict[str, Any]:
        """The ``machine`` message."""
        operated, profile = self._here(), self._profile
        assert profile is not None
        self._told = operated.values()
        return {
            **describing.describe(operated, profile, self.whys, self.named, self.own, self._defaults),
            "run": self.run,
        }

    def tick(self, now: float) -> list[Frame]:
        """Runs on to wall time; frames of the new rows, and of the ghost's."""
        if self.running != "running" or self._operated is None:
            self.pacer.pause()
            return [] if self._operated is None else self.live.flush() + self.ghost.flush()
        operated = self._operated
        frames: list[Frame] = []
        for thinner in (self.live, self.ghost):
            frames += thinner.pace(self.pacer.speed / operated.period_s)
        periods = self.pacer.due(now)
        if periods:
            began = time.perf_counter()
            rows, ghost = operated.advance(periods)
            self.pacer.spent(periods, time.perf_counter() - began)
            frames += self._seen(rows, ghost)
        if operated.diverged:
            self.running = "diverged"
            self.message = operated.diverged
            self._notice("error", f"The loop diverged and stands still: {operated.diverged}. Stop or reset it.")
        return frames

    def _seen(self, rows: np.ndarray, ghost: np.ndarray | None) -> list[Frame]:
        """New rows go to the scope, the figures, the views and the page."""
        operated = self._here()
        first = operated.period - len(rows)
        if len(rows):
            self.whys.feed(operated, rows)
        self.taking.feed(first, rows, self._about)
        self.figures.feed(rows)
        frames = self.live.feed(first, rows[:, 1:])
        if ghost is not None:
            self.figures.feed(ghost, ghost=True)
            frames += self.ghost.feed(operated.period - len(ghost), ghost[:, 1:])
        return frames

    def news(self) -> list[tuple[str, dict[str, Any]]]:
        """What pages have to be told, once."""
        found, self._news = self._news + self.taking.news(), []
        return found

    def why(self, views: tuple[str, ...]) -> dict[str, Any]:
        """The views named, now."""
        if self._operated is None:
            return {}
        found = self.whys.look(self._operated, views)
        return {"t": self._operated.period * self._operated.period_s, "views": found} if found else {}

    def fail(self, text: str) -> None:
        """Stands still at an error of ours, and builds anew at the next start."""
        self.running, self.message, self._broken = "stopped", text, True

    def close(self) -> str:
        """The session of the run is kept."""
        if self._operated is not None:
            self.records.ended(self._operated)
        return self.records.close()

    # Runs.

    def _here(self) -> Operated:
        if self._operated is None:
            raise DataError("the machine is being built; a moment")
        return self._operated

    def _build(self, start: Start, then: str = "stopped") -> Later:
        """Builds a machine in another thread; it takes this one's place when it is ready, in the state ``then``."""
        self._next, named, own = then, self.named, self.own

        def work() -> Made:
            describing.check_names(start.study, start.controller, start.scenario, named, own)
            profile = profile_of(start.study)
            controller, scenario = start.controller or profile.controller, start.scenario or profile.scenario
            return made(Operated(replace(start, controller=controller, scenario=scenario), profile))

        def done(found: Made) -> dict[str, Any]:
            self._touched, self._defaults = set(), {}
            return self._adopt(found)

        return Later(work, done)

    def _adopt(self, made: Made) -> dict[str, Any]:
        """The machine that was built is the machine from now on: a new run."""
        if self._operated is not None:
            self.records.ended(self._operated)
        self._operated, self._profile, self.whys = made
        self._broken = False
        operated = self._operated
        self.run += 1
        speed = self.pacer.speed
        self.pacer = Pacer(operated.period_s)
        self.pacer.speed = speed
        self.message = ""
        self._operated.compare(self._compare)
        self._refit()
        self.running = self._next
        return {"run": self.run, "study": operated.start.study, "t": 0.0}

    def _refit(self) -> None:
        """The loop has other columns: frames, scope and figures begin anew."""
        operated, profile = self._here(), self._profile
        assert profile is not None
        self.columns = list(operated.columns[1:])
        self.live, self.ghost = Thinner(LIVE, self.run), Thinner(GHOST, self.run)
        self.taking.watch(operated.columns, operated.units, operated.period_s)
        self._controller = operated.controller
        trace = next((t for p in profile.plots for t in p.traces if t.role == "error"), None)
        at = operated.columns.index(trace.signal) if trace else None
        self.figures = Figures(at, trace.factor if trace else 1.0, trace.unit if trace else "")
        self._afresh()
        self._news.append(("machine", {}))

    def _afresh(self) -> None:
        """Figures, and what captures are of, from this period on."""
        operated = self._here()
        self.figures.restart(operated.period)
        start = operated.start
        self._about = {"study": start.study, "controller": operated.controller, "scenario": start.scenario,
                       "values": plain(operated.values())}  # fmt: skip

    def _again(self, then: str) -> Later:
        """The same machine at t = 0 and at rest; what the operator set stays set, unless the loop diverged under it."""
        operated = self._here()
        self._next = then
        if operated.diverged:
            self._touched = set()
        kept, apart = self._kept(operated)
        axes = {k: e.default for k, e in operated.sheet.items() if k.removeprefix("y.") in self._touched_keys()}
        defaults = {**axes, **self._defaults}

        def build() -> Made:
            same = operated.controller == (operated.start.controller or "")
            if operated.diverged or (same and not kept and not apart):
                return made(operated.restarted())
            start = replace(operated.start, controller=operated.controller or None)
            settable = start.experiment().settable()
            changes = {**start.changes, **{k: v for k, v in kept.items() if k in settable}}
            new = Operated(replace(start, changes={k: v for k, v in changes.items() if k in settable}))
            if known := {k: v for k, v in apart.items() if k[2:] in new.sheet}:
                new.schedule(0, known, "kept from the run before")
            return made(new)

        def work() -> Made | Exception:
            try:
                return build()
            except Exception as error:
                return error

        def done(found: Made | Exception) -> dict[str, Any]:
            self._pending = False
            if isinstance(found, Exception):
                raise found
            self._defaults = defaults
            return self._adopt(found)

        self._pending = True
        return Later(work, done)

    def _kept(self, operated: Operated) -> tuple[dict[str, Any], dict[str, Any]]:
        """What the operator set, as it is now: of both axes, and, behind ``x.`` and ``y.``, where the two differ."""
        values = operated.values()
        both = {k: values[k] for k in self._touched_keys() if k in values}
        apart = [k for k in both if f"y.{k}" in values and not np.array_equal(both[k], values[f"y.{k}"])]
        lone = {f"{axis}{k}": values[f"y.{k}" if axis == "y." else k] for k in apart for axis in PREFIXES}
        return {k: v for k, v in both.items() if k not in apart}, lone

    def _touched_keys(self) -> list[str]:
        """What the operator set, without the axis."""
        return sorted({k[2:] if k[:2] in PREFIXES else k for k in self._touched})

    def _do_machine(self, args: dict[str, Any]) -> Later:
        return self._build(Start(args["study"], args["controller"], args["scenario"], args["changes"] or {},
                                 args["seed"], None, args["circle"]))  # fmt: skip

    def _do_start(self, args: dict[str, Any]) -> dict[str, Any] | Later:
        operated = self._here()
        if self._pending:
            self._next = "running"
            return self._now()
        if operated.diverged:
            raise ValueRefused(f"the loop diverged ({operated.diverged}): stop or reset it first")
        if self._broken:
            return self._again("running")
        self.running, self.message = "running", ""
        return self._now()

    def _do_hold(self, args: dict[str, Any]) -> dict[str, Any]:
        if self.running != "running":
            raise ValueRefused(f"the machine is {self.running}: only a running one can be held")
        self.running = "held"
        return self._now()

    def _do_stop(self, args: dict[str, Any]) -> dict[str, Any] | Later:
        self._here()
        self.running = "stopped"
        return self._again("stopped")

    def _do_reset(self, args: dict[str, Any]) -> Later:
        self._here()
        then = self.running if self.running in ("running", "held") else "stopped"
        return self._again("stopped" if then == "held" else then)

    def _do_speed(self, args: dict[str, Any]) -> dict[str, Any]:
        if not SLOWEST <= args["value"] <= FASTEST:
            raise ValueRefused(f"speed = {args['value']:g}: allowed range is [{SLOWEST:g}, {FASTEST:g}] s per second")
        old, self.pacer.speed = self.pacer.speed, args["value"]
        self.pacer.pause()
        return self._now() | {"old": {"speed": old}, "new": {"speed": args["value"]}}

    def _now(self) -> dict[str, Any]:
        operated = self._here()
        return {"period": operated.period, "t": operated.period * operated.period_s}

    def _notice(self, level: str, text: str) -> None:
        self._news.append(("notice", {"level": level, "text": text}))


def made(operated: Operated) -> Made:
    """A machine with what is shown of it."""
    return operated, fitted(operated.profile, operated.loop), Whys(operated)


__all__ = ["Made", "SimRun", "made"]
