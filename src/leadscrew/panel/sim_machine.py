"""A simulated machine under the panel: its commands, its state, and what is kept of it."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.kernel.errors import DataError, LeadscrewError, NameUnknown, ValueRefused
from leadscrew.kernel.sheet import nearest
from leadscrew.panel import describing, presets, taking
from leadscrew.panel.machine import Later
from leadscrew.panel.plain import plain
from leadscrew.panel.sim_run import SimRun, made

if TYPE_CHECKING:
    from leadscrew.operate.operated import Change, Operated

CHANGES = {"set", "undo", "redo", "switch", "disturb", "preset_load", "stop", "reset", "safe"}
"""What a machine that is being set back takes no part of."""


class SimMachine(SimRun):
    """A :class:`~leadscrew.panel.machine.Machine` that is simulated."""

    def ask(self, do: str, args: dict[str, Any]) -> dict[str, Any] | Later:
        """Obeys one command."""
        if do in taking.COMMANDS:
            return self.taking.ask(do, args)
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
            "figures": self.figures.state(operated.period_s),
            "scope": self.taking.state(),
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
        describing.check_names(operated.start.study, controller, None, self.named, self.own)

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
        values = {k: v for k, v in operated.values().items() if k in operated.sheet and np.isfinite(v).all()}
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


__all__ = ["SimMachine"]
