"""What the signals of a loop look like, found by running its steps once in plain Python."""

from __future__ import annotations

import traceback
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.kernel.block import Block
from leadscrew.kernel.frame import as_floats, bundle
from leadscrew.kernel.layout import copied, is_branch
from leadscrew.kernel.noise import Noise
from leadscrew.kernel.source import where
from leadscrew.kernel.subset import PRINT
from leadscrew.util.errors import BlockError, LeadscrewError
from leadscrew.util.frames import place

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop


def _kind(value: Any) -> str:
    """What a signal is, for a message: a number, or the names of a NamedTuple."""
    return f"{type(value).__name__}({', '.join(value._fields)})" if is_branch(value) else "as a number"


def _what(value: Any) -> str:
    """What a step returned, for a message."""
    if isinstance(value, tuple) and not is_branch(value):
        return f"{len(value)} values"
    return type(value).__name__ if is_branch(value) else repr(value)


def _silent(*_: Any) -> None:
    """What ``print`` does in a probe."""


class _Probe:
    def __init__(self, loop: Loop) -> None:
        self.loop = loop
        self.module = loop.module
        self.names: dict[str, str] = {}
        for slot, block in loop.blocks.items():
            if block is not None:
                for value, arg in ((loop.prepared(block, slot), "p"), (block.state, "s")):
                    if is_branch(value):
                        self.module.arguments[id(block.step), arg] = type(value)
                self.names[slot] = self.module.callable(block.step)
        plant = loop.blocks["plant"]
        assert plant is not None
        self.shown = plant.output if plant.output is not None else plant.state._fields[0]
        if callable(self.shown):
            self.module.arguments[id(self.shown), "s"] = type(plant.state)
            self.names["shown"] = self.module.callable(self.shown)
        self.space = self.module.namespace()

    def call(self, slot: str, **signals: Any) -> Any:
        block = self.loop.blocks[slot]
        if block is None:
            return None
        lead = [self.loop.prepared(block, slot)] if block.params is not None else []
        state = None if block.state is None else copied(self.loop.start_state(block))
        if state is not None:
            lead.append(state)
        given = {n: signals[n] for n in block.signals if n in ("command", "feedback", "actual", "output")}
        result = self._tried(block.name, slot, *lead, *(signals[n] for n in block.signals), given=given)
        if state is not None and isinstance(result, tuple) and result:
            self._arrays_stay(block.name, state, result if slot == "plant" else result[0], "")
        try:
            return self._signal(block, slot, result)
        except BlockError as error:
            raise BlockError(f"{where(block.step)}{error}") from None

    def _arrays_stay(self, name: str, old: Any, new: Any, key: str) -> None:
        """Refuses a next state with other arrays than the state had: compiled loops write arrays where they lie."""
        if isinstance(old, np.ndarray) and new is not old:
            raise BlockError(
                f"{name}: the next state has another array as {key!r}; write into the array of the state, element by "
                "element, and return that one"
            )
        if is_branch(old) and type(new) is type(old):
            for field, a, b in zip(old._fields, old, new, strict=True):
                self._arrays_stay(name, a, b, f"{key}.{field}" if key else field)

    def _tried(self, name: str, step: str, *args: Any, given: Mapping[str, Any] | None = None) -> Any:
        """Calls a step; what it raises becomes one sentence with file, line and the signals that it was given."""
        try:
            self.space[PRINT] = _silent
            with np.errstate(all="ignore"):
                return self.space[self.names[step]](*args)
        except LeadscrewError:
            raise
        except Exception as error:
            frames = traceback.extract_tb(error.__traceback__)[1:]
            at = f"{place(frames[-1].filename, frames[-1].lineno or 0)}: " if frames else ""
            signals = ", ".join(f"{signal} {_kind(value)}" for signal, value in (given or {}).items())
            raise BlockError(
                f"{at}in {name!r}, in the first period: {type(error).__name__}: {error}"
                + (f"; it was given {signals}" if signals else "")
            ) from None
        finally:
            self.space[PRINT] = print

    def _signal(self, block: Block, slot: str, result: Any) -> Any:
        state = type(block.state).__name__
        if result is None:
            raise BlockError("it returned nothing: missing 'return'?")
        if slot == "plant":
            if type(result) is not type(block.state):
                raise BlockError(f"it returned {_what(result)}; a plant returns its state {state}, or its derivative")
            return result
        if block.state is None:
            if isinstance(result, tuple) and not is_branch(result):
                raise BlockError(f"it returned {_what(result)}; a step without state returns its signal alone")
            return as_floats(result)
        if not (isinstance(result, tuple) and not is_branch(result) and len(result) == 2):
            raise BlockError(f"it returned {_what(result)}; a step with state returns (next_state, signal)")
        if type(result[0]) is not type(block.state):
            raise BlockError(f"its next state is {_what(result[0])}, not {state}")
        return as_floats(result[1])

    def actual(self) -> Any:
        plant = self.loop.blocks["plant"]
        assert plant is not None
        state = self.loop.start_state(plant)
        if not callable(self.shown):
            for part in str(self.shown).split("."):
                if not hasattr(state, part):
                    raise BlockError(f"{plant.name}: output={self.shown!r} is not a field of its state {state._fields}")
                state = getattr(state, part)
            return as_floats(state)
        wanted = self.shown.__code__.co_varnames[: self.shown.__code__.co_argcount]
        given = {"p": self.loop.prepared(plant, "plant"), "s": state}
        if not set(wanted) <= set(given):
            raise BlockError(f"{plant.name}: its output function may take p and s, not {', '.join(wanted)}")
        return as_floats(self._tried(plant.name, "shown", *(given[n] for n in wanted)))


def example_signals(loop: Loop) -> dict[str, Any]:
    """One example of each signal at the first period.

    Raises:
        BlockError, SubsetError: a step that returns something else than its kind does, or cannot be compiled.
    """
    probe = _Probe(loop)
    clock: dict[str, Any] = {"t": 0.0, "dt": loop.period, "noise": Noise(loop.seed, 0, 0, 0)}
    command = probe.call("reference", **clock)
    load = probe.call("disturbance", **clock)
    actual = probe.actual()
    feedback = probe.call("sensor", actual=actual, **clock)
    feedback = actual if feedback is None else feedback
    output = probe.call("controller", command=command, feedback=feedback, **clock)
    applied = probe.call("actuator", output=output, **clock)
    applied = output if applied is None else applied
    load = 0.0 if load is None else load
    probe.call("output_disturbance", **clock)
    plant_dt = {"dt": loop.step, "t": 0.0}
    plant = loop.blocks["plant"]
    assert plant is not None
    probe.call("plant", u=applied, load=load, **plant_dt)
    found = {
        "command": command,
        "feedback": feedback,
        "output": output,
        "applied": applied,
        "actual": actual,
        "load": load,
    }
    found["_all"] = bundle("Signals", found)
    return found
