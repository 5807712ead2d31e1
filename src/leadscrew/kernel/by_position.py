"""A controller of numbers where the loop has records: it gets the position of the command, of the feedback, or both.

So ``pid`` works behind ``s_curve``, whose command is a motion, and on ``servo_axis``, which shows the table and the
motor. A controller that takes the records as they are gets them whole.
"""

from __future__ import annotations

import contextlib
import io
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any
from weakref import WeakKeyDictionary

from leadscrew.kernel.block import Block
from leadscrew.kernel.layout import copied
from leadscrew.kernel.noise import Noise

SIGNALS = (("command", "feedback"), ("command", "feedback", "dt"))

_examples: WeakKeyDictionary[Callable[..., Any], Any] = WeakKeyDictionary()
"""What the step of a reference or a sensor gives, and what a plant shows: the same for all parameters."""


def by_position(blocks: Mapping[str, Block | None], dt: float) -> Block:
    """The controller of a loop, with the positions of the records that it cannot take."""
    controller = blocks["controller"]
    assert controller is not None
    if getattr(controller.step, "takes_motion", False) or controller.signals not in SIGNALS:
        return controller
    command, feedback = _command(blocks, dt), _feedback(blocks, dt)
    has = tuple(isinstance(getattr(signal, "position", None), float | int) for signal in (command, feedback))
    if not any(has) or _takes(controller, command, feedback, dt) is not TypeError:
        return controller
    for reads in ((True, False), (False, True), (True, True)):
        if all(h or not r for h, r in zip(has, reads, strict=True)):
            found = _reading(controller, *reads)
            if _takes(found, command, feedback, dt) is None:
                return found
    return controller


def _command(blocks: Mapping[str, Block | None], dt: float) -> Any:
    reference = blocks["reference"]
    assert reference is not None
    return _example(reference, {"t": 0.0, "dt": dt, "noise": Noise(0, 0, 0, 0)})


def _feedback(blocks: Mapping[str, Block | None], dt: float) -> Any:
    plant, sensor = blocks["plant"], blocks["sensor"]
    assert plant is not None
    actual = _shown(plant, dt)
    if sensor is None or actual is None:
        return actual
    return _example(sensor, {"actual": actual, "t": 0.0, "dt": dt, "noise": Noise(0, 0, 0, 0)})


def _shown(plant: Block, dt: float) -> Any:
    """What a plant shows at the start; none where that cannot be computed."""
    state = _state(plant)
    if callable(plant.output):
        names = plant.output.__code__.co_varnames[: plant.output.__code__.co_argcount]
        with contextlib.suppress(Exception):
            given = {"p": prepared(plant, dt), "s": state}
            return plant.output(*(given[name] for name in names))
        return None
    with contextlib.suppress(Exception):
        for part in (plant.output or plant.state._fields[0]).split("."):
            state = getattr(state, part)
        return state
    return None


def _example(block: Block, signals: Mapping[str, Any]) -> Any:
    """The signal of a block at the start; none where its step cannot run."""
    if block.step not in _examples:
        found = None
        with contextlib.suppress(Exception), contextlib.redirect_stdout(io.StringIO()):
            result = block.step(*_lead(block, signals["dt"]), *(signals[name] for name in block.signals))
            found = result if block.state is None else result[1]
        _examples[block.step] = found
    return _examples[block.step]


def _takes(controller: Block, command: Any, feedback: Any, dt: float) -> type[Exception] | None:
    """What a controller raises on these signals."""
    given = {"command": command, "feedback": feedback, "dt": dt}
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            controller.step(*_lead(controller, dt), *(given[name] for name in controller.signals))
    except Exception as error:
        return TypeError if isinstance(error, TypeError) else type(error)
    return None


def _lead(block: Block, dt: float) -> list[Any]:
    """Parameters and state, where a step has them."""
    lead = [] if block.params is None else [prepared(block, dt)]
    return lead if block.state is None else [*lead, _state(block)]


def prepared(block: Block, dt: float, params: Any = None) -> Any:
    """What the step of a block gets as ``p`` at this period; ``params`` count in place of its own."""
    own = block.params if params is None else params
    return own if block.prepare is None else block.prepare(own, dt)


def _state(block: Block) -> Any:
    return copied(block.initial(block.params) if block.initial is not None else block.state)


def position_of(signal):
    """The position of a record."""
    return signal.position


def whole(signal):
    """A signal as it is."""
    return signal


def _reading(controller: Block, of_command: bool, of_feedback: bool) -> Block:
    """The controller on the positions of command, feedback, or both."""
    law, timed = controller.step, "dt" in controller.signals
    r, y = (position_of if reads else whole for reads in (of_command, of_feedback))

    def with_both(p, s, command, feedback, dt):
        return law(p, s, r(command), y(feedback), dt)

    def with_both_untimed(p, s, command, feedback):
        return law(p, s, r(command), y(feedback))

    def with_parameters(p, command, feedback, dt):
        return law(p, r(command), y(feedback), dt)

    def with_parameters_untimed(p, command, feedback):
        return law(p, r(command), y(feedback))

    def with_state(s, command, feedback, dt):
        return law(s, r(command), y(feedback), dt)

    def with_state_untimed(s, command, feedback):
        return law(s, r(command), y(feedback))

    def bare(command, feedback, dt):
        return law(r(command), y(feedback), dt)

    def bare_untimed(command, feedback):
        return law(r(command), y(feedback))

    step: Any = {
        (True, True): (with_both_untimed, with_both), (True, False): (with_parameters_untimed, with_parameters),
        (False, True): (with_state_untimed, with_state), (False, False): (bare_untimed, bare),
    }[controller.params is not None, controller.state is not None][timed]  # fmt: skip
    step.takes_motion = of_command
    align: Any = controller.align

    def aligned(params, command, feedback, output):
        return align(params, r(command), y(feedback), output)

    names = ("command", "feedback", "dt") if timed else ("command", "feedback")
    return replace(controller, step=step, signals=names, align=None if align is None else aligned)
