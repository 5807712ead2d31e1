"""A simulated machine under the panel: its runs, its commands, its state, and what is kept of it.

A run is built beside, kept to wall time, held, stopped and begun again.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.kernel.parameters import nearest
from leadscrew.operate.axes import PREFIXES
from leadscrew.operate.operated import Operated, Start
from leadscrew.operate.profile import Profile, fitted
from leadscrew.operate.profiles import profile_of
from leadscrew.panel import description, presets, scope_commands
from leadscrew.panel.error_sums import ErrorSums
from leadscrew.panel.explanations import Explanations
from leadscrew.panel.frames import GHOST, LIVE, Frame, Thinner
from leadscrew.panel.machine import Later
from leadscrew.panel.pacing import FASTEST, SLOWEST, Pacer
from leadscrew.panel.records import Records
from leadscrew.panel.strict_json import plain
from leadscrew.util.errors import DataError, LeadscrewError, NameUnknown, ValueRefused

if TYPE_CHECKING:
    from leadscrew.operate.operated import Change, Operated

Made = tuple[Operated, Profile, Explanations]
CHANGES = {"set", "undo", "redo", "switch", "disturb", "preset_load", "stop", "reset", "safe"}
"""What a machine that is being set back takes no part of."""


class SimMachine:
    """A :class:`~leadscrew.panel.machine.Machine` that is simulated.

    One at a time: another study, scenario or run takes its place here.
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
        self.scope = scope_commands.ScopeCommands(folder / "captures")
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
            **description.describe(operated, profile, self.whys, self.named, self.own, self._defaults),
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
            self._notice("error", f"The loop diverged and is stopped: {operated.diverged}. Stop or reset it.")
        return frames

    def _seen(self, rows: np.ndarray, ghost: np.ndarray | None) -> list[Frame]:
        """New rows go to the scope, the figures, the views and the page."""
        operated = self._here()
        first = operated.period - len(rows)
        if len(rows):
            self.whys.feed(operated, rows)
        self.scope.feed(first, rows, self._about)
        self.error_sums.feed(rows)
        frames = self.live.feed(first, rows[:, 1:])
        if ghost is not None:
            self.error_sums.feed(ghost, ghost=True)
            frames += self.ghost.feed(operated.period - len(ghost), ghost[:, 1:])
        return frames

    def news(self) -> list[tuple[str, dict[str, Any]]]:
        """What pages have to be told, once."""
        found, self._news = self._news + self.scope.news(), []
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
            description.check_names(start.study, start.controller, start.scenario, named, own)
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
        self.scope.watch(operated.columns, operated.units, operated.period_s)
        self._controller = operated.controller
        trace = next((t for p in profile.plots for t in p.traces if t.role == "error"), None)
        at = operated.columns.index(trace.signal) if trace else None
        self.error_sums = ErrorSums(at, trace.factor if trace else 1.0, trace.unit if trace else "")
        self._afresh()
        self._news.append(("machine", {}))

    def _afresh(self) -> None:
        """ErrorSums, and what captures are of, from this period on."""
        operated = self._here()
        self.error_sums.restart(operated.period)
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

    # ---- commands
    def ask(self, do: str, args: dict[str, Any]) -> dict[str, Any] | Later:
        """Obeys one command."""
        if do in scope_commands.COMMANDS:
            return self.scope.ask(do, args)
        if self._pending and do in CHANGES:
            raise DataError(f"{do}: the machine is being set back; a moment")
        act: Callable[[dict[str, Any]], dict[str, Any] | Later] | None = getattr(self, f"_do_{do}", None)
        if act is None:
            known = [n.removeprefix("_do_") for n in dir(self) if n.startswith("_do_")]
            raise NameUnknown(f"this machine has no command {do!r}{nearest(do, known)}")
        if do not in CHANGES:
            return act(args)
        found = _obeyed(do, args, lambda: act(args))
        if isinstance(found, Later):
            later = found
            return Later(
                lambda: _obeyed(do, args, later.work), lambda made: _obeyed(do, args, lambda: later.done(made))
            )
        return found

    def state(self) -> dict[str, Any]:
        """The machine's part of the ``state`` message."""
        operated = self._operated
        found: dict[str, Any] = {"running": self.running, "speed": self.pacer.speed, "message": self.message}
        if operated is None:
            return found | {"t": 0.0, "period": 0, "behind": False, "changed": {}, "ghost": None, "figures": None,
                            "scope": {}, "can_undo": False, "can_redo": False}  # fmt: skip
        return found | {
            "t": operated.period * operated.period_s,
            "period": operated.period,
            "behind": self.running == "running" and self.pacer.behind(time.monotonic()),
            "changed": self._changed(),
            "ghost": self._ghost(operated),
            "compare": self._compare,
            "figures": self.error_sums.state(operated.period_s),
            "scope": self.scope.state(),
            "can_undo": operated.can_undo,
            "can_redo": operated.can_redo,
        }

    # Changes.

    def _do_set(self, args: dict[str, Any]) -> dict[str, Any]:
        change = self._here().set(args["changes"], why=args.get("why", ""))
        self._touched |= set(args["changes"])
        return self._done(change)

    def _do_undo(self, args: dict[str, Any]) -> dict[str, Any]:
        return self._done(self._here().undo())

    def _do_redo(self, args: dict[str, Any]) -> dict[str, Any]:
        return self._done(self._here().redo())

    def _do_safe(self, args: dict[str, Any]) -> dict[str, Any]:
        return self._done(self._here().safe(args["why"]))

    def _do_disturb(self, args: dict[str, Any]) -> dict[str, Any]:
        return self._told_of(self._here().disturb(args["name"], args["fields"] or {}))

    def _do_compare(self, args: dict[str, Any]) -> dict[str, Any]:
        old, self._compare = self._compare, args["mode"]
        self._here().compare(args["mode"])
        return self._now() | {"old": {"compare": old}, "new": {"compare": args["mode"]}}

    def _do_switch(self, args: dict[str, Any]) -> Later:
        return self._switched(args["controller"], lambda: {})

    def _switched(self, controller: str, then: Callable[[], dict[str, Any]]) -> Later:
        """Another controller, compiled while the machine runs on, and what follows at once."""
        operated = self._here()
        description.check_names(operated.start.study, controller, None, self.named, self.own)

        def done(prepared: Any) -> dict[str, Any]:
            if operated is not self._operated:
                raise ValueRefused("another run began before the controller was ready; switch again")
            first = self._done(operated.switch(prepared))
            also = then()
            how = also["how"] if also.get("new") else first["how"]
            return {**first, **also, "how": how, **{k: {**first[k], **also.get(k, {})} for k in ("old", "new")}}

        return Later(lambda: operated.prepare(controller), done)

    def _done(self, change: Change) -> dict[str, Any]:
        """After a change by the operator: figures and ghost begin at it."""
        operated = self._here()
        self.ghost.flush()
        if self._controller != operated.controller:
            self._defaults = {k: v for k, v in self._defaults.items() if ".controller." not in f".{k}"}
        if self.columns != operated.columns[1:]:
            _, self._profile, self.whys = made(operated)
            self._refit()
        elif self._controller != operated.controller:
            # The columns are the same: scope, frames and an armed trigger go on.
            _, self._profile, self.whys = made(operated)
            self._controller = operated.controller
            self._news.append(("machine", {}))
        self._afresh()
        return self._told_of(change)

    def _told_of(self, change: Change) -> dict[str, Any]:
        return {
            **self._now(), "period": change.period, "old": plain(change.old), "new": plain(change.new),
            "how": change.how, "before": change.before, "after": change.after,
        }  # fmt: skip

    def _ghost(self, operated: Operated) -> dict[str, Any] | None:
        """The label of the ghost, for the ``state`` message."""
        found = operated.ghost
        return None if found is None else {"label": found.label, "since_s": found.since * operated.period_s}

    def _changed(self) -> dict[str, Any]:
        """Values now that differ from those of the last ``machine`` message."""
        values = self._here().values()
        told = self._told
        return {k: plain(v) for k, v in values.items() if k not in told or not np.array_equal(v, told[k])}

    # Records.

    def _do_presets(self, args: dict[str, Any]) -> dict[str, Any]:
        return {"presets": presets.names(self.folder / "presets")}

    def _do_preset_save(self, args: dict[str, Any]) -> dict[str, Any]:
        operated = self._here()
        known = {k: v for k, v in operated.values().items() if k in operated.sheet}
        values = {k: v for k, v in known.items() if isinstance(v, str) or np.isfinite(v).all()}
        found = presets.Preset(operated.start.study, operated.controller, values)
        return {"name": presets.save(found, self.folder / "presets", args["name"]).stem}

    def _do_preset_delete(self, args: dict[str, Any]) -> dict[str, Any]:
        presets.delete(self.folder / "presets", args["name"])
        return {}

    def _do_preset_load(self, args: dict[str, Any]) -> dict[str, Any] | Later:
        operated = self._here()
        found = presets.load(self.folder / "presets", args["name"])
        if found.study != operated.start.study:
            raise ValueRefused(
                f"the preset {args['name']} is of the machine {found.study}, and this is {operated.start.study}: "
                "choose that machine first"
            )
        why = f"preset {args['name']}"
        if found.controller == operated.controller:
            return self._do_set({"changes": self._differing(found.values), "why": why})
        return self._switched(found.controller, lambda: self._preset_set(found.values, why))

    def _preset_set(self, values: Mapping[str, Any], why: str) -> dict[str, Any]:
        """The values of a preset after its controller; a preset that does not fit takes the controller back again."""
        try:
            return self._do_set({"changes": self._differing(values), "why": why})
        except LeadscrewError:
            self._done(self._here().undo())
            raise

    def _differing(self, wanted: Mapping[str, Any]) -> dict[str, Any]:
        """The values that are not so already; all of them where there is none, so that they are checked."""
        values = self._here().values()
        other = {k: v for k, v in wanted.items() if k not in values or not np.array_equal(values[k], v)} or dict(wanted)
        # Of two axes a plain key is the first one's value; set, it would be both's.
        return {f"x.{k}" if f"y.{k}" in values else k: v for k, v in other.items()}

    def _do_session(self, args: dict[str, Any]) -> Later:
        return self.records.text(self._operated, args["format"])

    def _do_session_save(self, args: dict[str, Any]) -> Later:
        return self.records.save(self._operated, args["name"])


def made(operated: Operated) -> Made:
    """A machine with what is shown of it."""
    return operated, fitted(operated.profile, operated.loop), Explanations(operated)


def _obeyed(do: str, args: Mapping[str, Any], act: Callable[[], Any]) -> Any:
    """What ``act`` gives. All values are checked, and a loop is made of them, before any is set: one that the loop
    cannot compute with is refused, and the machine runs on.
    """
    try:
        return act()
    except (ArithmeticError, ValueError, IndexError, MemoryError) as error:
        if isinstance(error, LeadscrewError):
            raise
        said = ", ".join(f"{k} = {v!r}" for k, v in list((args.get("changes") or {}).items())[:3]) or do
        raise ValueRefused(f"{said[:200]}: the machine cannot compute with it ({error})") from None
