"""Two controllers in series: the output of the first is the command of the second.

    u1 = first(command, feedback),        u = second(u1, 0)

``series(pid, notch)`` is a PID whose output goes through a notch; ``series(notch, pid)`` filters the error of a PID.
Parameters and state nest under the names of the two: ``controller.pid.kp``, ``controller.notch.centre_hz``; of two with
one name the second is ``pid_2``. A limit of the first comes before the second, which may overshoot it.

Unit, drive and full scale are those of the second, or of the first where the second has none (a filter). Bumpless start
where one of the two is a filter of :mod:`leadscrew.controllers._filters` and the other can be aligned.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple, cast

from leadscrew.controllers._filters import FILTERS
from leadscrew.controllers._wrapping import takes_motion
from leadscrew.kernel.block import Block, make
from leadscrew.kernel.by_position import prepared
from leadscrew.util.errors import BlockError, entry_point


@entry_point
def series(first: Block, second: Block, name: str = "") -> Block:
    """The controller whose ``first`` part commands its ``second`` one; both are sampled controllers with parameters.

    Raises:
        BlockError: a block that is no sampled controller with parameters, or takes other signals than command, feedback
            and dt; a second one that needs a command with velocity.
    """
    for block in (first, second):
        _check(block)
    if takes_motion(second):
        raise BlockError(
            f"series({first.name}, {second.name}): {second.name} needs a motion, not the output of another"
        )
    head = _name(first)
    tail = _name(second) if _name(second) != head else f"{head}_2"
    laws = _timed(first), _timed(second)
    starts = _start(first), _start(second)
    names = {
        "params": (head, tail),
        "state": tuple(n for n, s in zip((head, tail), starts, strict=True) if s is not None),
    }
    params_type = _bundle("SeriesParams", names["params"], (first.params, second.params))
    kept = tuple(s for s in starts if s is not None)
    state_type = _bundle("SeriesState", names["state"], kept)

    def prepare(params: Any, dt: float) -> Any:
        ready = [prepared(block, dt, part) for block, part in zip((first, second), params, strict=True)]
        return _bundle("SeriesPlan", names["params"], ready)(*ready)

    def initial(params: Any) -> Any:
        both = (_start(replace(b, params=part)) for b, part in zip((first, second), params, strict=True))
        return state_type(*(s for s in both if s is not None))

    step = _steps(head, tail, *laws, state_type)[tuple(s is not None for s in starts)]
    step.takes_motion = takes_motion(first)
    main = second if second.drive or second.unit else first
    return make(
        "controller", step, params_type(first.params, second.params), state_type(*kept) if kept else None,
        prepare=prepare, initial=initial if first.initial or second.initial else None,
        align=_align(head, tail, first, second, state_type), unit=main.unit, drive=main.drive,
        full_scale=main.full_scale,
        sense=first.sense * second.sense, doc=f"{first.name}, then {second.name}: {first.doc} {second.doc}".strip(),
        name=name or f"{head}_{tail}",
    )  # fmt: skip


def _steps(head: str, tail: str, one: Callable[..., Any], two: Callable[..., Any], state_type: Any) -> dict[Any, Any]:
    """The step by which of the two have a state."""

    def both(p, s, command, feedback, dt):
        before, u = one(getattr(p, head), getattr(s, head), command, feedback, dt)
        after, output = two(getattr(p, tail), getattr(s, tail), u, 0.0, dt)
        return state_type(before, after), output

    def former(p, s, command, feedback, dt):
        before, u = one(getattr(p, head), getattr(s, head), command, feedback, dt)
        return state_type(before), two(getattr(p, tail), u, 0.0, dt)

    def latter(p, s, command, feedback, dt):
        u = one(getattr(p, head), command, feedback, dt)
        after, output = two(getattr(p, tail), getattr(s, tail), u, 0.0, dt)
        return state_type(after), output

    def neither(p, command, feedback, dt):
        return two(getattr(p, tail), one(getattr(p, head), command, feedback, dt), 0.0, dt)

    return {(True, True): both, (True, False): former, (False, True): latter, (False, False): neither}


def _timed(block: Block) -> Callable[..., Any]:
    """The step of a block, with the period as its last argument whether it takes it or not."""
    step = block.step
    if "dt" in block.signals:
        return step

    def with_state(p, s, command, feedback, dt):
        return step(p, s, command, feedback)

    def without(p, command, feedback, dt):
        return step(p, command, feedback)

    return without if block.state is None else with_state


def _align(head: str, tail: str, first: Block, second: Block, state_type: Any) -> Callable[..., Any] | None:
    """A bumpless start where one of the two is a filter: at rest the error or the output stands between them."""
    if first.align is None or second.align is None or not {first.step, second.step} & set(FILTERS):
        return None
    align_first, align_second = first.align, second.align

    def of_error(params, command, feedback, output):
        before = align_first(getattr(params, head), command, feedback, command - feedback)
        return state_type(before, align_second(getattr(params, tail), command - feedback, 0.0, output))

    def of_output(params, command, feedback, output):
        before = align_first(getattr(params, head), command, feedback, output)
        return state_type(before, align_second(getattr(params, tail), output, 0.0, output))

    return of_error if first.step in FILTERS else of_output


def _start(block: Block) -> Any:
    return block.initial(block.params) if block.initial is not None else block.state


def _name(block: Block) -> str:
    return block.name.replace(".", "_")


def _bundle(name: str, fields: tuple[str, ...], values: Any) -> Any:
    return cast(Any, NamedTuple(name, [(n, type(v)) for n, v in zip(fields, values, strict=True)]))


def _check(block: Block) -> None:
    if not isinstance(block, Block) or block.kind != "controller" or block.continuous or block.params is None:
        name = getattr(block, "name", repr(block))
        raise BlockError(f"series: {name} is not a sampled controller with parameters")
    if block.signals not in (("command", "feedback", "dt"), ("command", "feedback")):
        raise BlockError(f"series: {block.name} takes {', '.join(block.signals)}; expected command, feedback and dt")
