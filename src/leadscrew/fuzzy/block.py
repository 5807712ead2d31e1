"""A fuzzy system inside a loop: as a controller block, or as a plain function that a step calls.

The usual controller takes the error and its change, scaled into the universes, and scales what comes out:

    e = error_scale (command - feedback)
    de = change_scale (e_k - e_(k-1)) / scale of the error            (the change of the error in one period)
    output = output_scale y          or, with ``incremental``, output_k = output_(k-1) + output_scale y

Where the command is a motion, ``command="position"`` says which of its fields that is; ``feedback`` likewise.

:func:`controller` makes it; :func:`function` is for everything else: it may be called inside any step.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from keyword import iskeyword
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np

from leadscrew.fuzzy.engine import Engine, engine, execute
from leadscrew.fuzzy.system import System
from leadscrew.fuzzy.tables import Tables
from leadscrew.fuzzy.writer import identifiers
from leadscrew.kernel.block import Block, InputRange, make
from leadscrew.kernel.parameters import Doc, nearest
from leadscrew.util.errors import NameUnknown, ValueRefused, entry_point
from leadscrew.util.escape import python_docstring

SIGNALS = {
    "error": "error",
    "change": "error - before",
    "rate": "(error - before) / dt",
    "command": "command",
    "feedback": "feedback",
    "integral": "total",
}
"""What an input of the system may be taken from: the error, its change in a period, its rate in a second, the signals
themselves, or the sum of the error over time."""


@entry_point
def function(system: System) -> Callable[..., Any]:
    """The system as a plain function ``f(input, ...)`` with its numbers frozen, for use inside steps.

    Gives one float, or a tuple where there are several outputs. An output that keeps its last value
    (``lock_previous``) is taken as a further argument, behind the inputs.
    """
    made = engine(system)
    writer = made.writer
    given = [*writer.inputs, *(writer.last(o) for o in writer.live if o.lock_previous)]
    space = dict(made.space)
    for field, array in zip(made.plan_type._fields, made.plan, strict=True):
        space[f"PLAN_{field}"] = np.ascontiguousarray(array)
    plan = ", ".join(f"PLAN_{f}" for f in made.plan_type._fields)
    name = identifiers([system.name or "fuzzy"], made.space)[system.name or "fuzzy"]
    lines = [
        f"def {name}({', '.join(given)}):",
        f'    """The fuzzy system {python_docstring(system.name)}."""',
        f"    return infer(Plan({plan}), {', '.join(given)})",
    ]
    space["Plan"] = made.plan_type
    found: Callable[..., Any] = execute("\n".join(lines) + "\n", f"{system.name} function", space)[name]
    return found


class Scaled(NamedTuple):
    """One input of the system and where it comes from."""

    source: str
    """One of :data:`SIGNALS`."""
    scale: float = 1.0


def _mapping(system: System, inputs: Mapping[str, Any] | None) -> dict[str, Scaled]:
    """Where each input comes from."""
    names = [v.name for v in system.inputs]
    if inputs is None:
        if len(names) > 2:
            raise ValueRefused(
                f"system {system.name} has {len(names)} inputs ({', '.join(names)}); say where each comes from: "
                f"inputs={{name: source or (source, scale)}}, sources are {', '.join(SIGNALS)}"
            )
        return {n: Scaled(s) for n, s in zip(names, ("error", "change"), strict=False)}
    for name in inputs:
        if name not in names:
            raise NameUnknown(f"system {system.name} has no input {name!r}{nearest(name, names)}")
    found = {}
    for name in names:
        if name not in inputs:
            raise ValueRefused(f"system {system.name}: nothing is said about the input {name}")
        given = inputs[name]
        scaled = Scaled(given) if isinstance(given, str) else Scaled(*given)
        if scaled.source not in SIGNALS:
            raise NameUnknown(
                f"input {name}: there is no signal {scaled.source!r}{nearest(scaled.source, list(SIGNALS))}"
            )
        found[name] = scaled
    return found


class Memory(NamedTuple):
    """What the controller remembers."""

    before: Annotated[float, Doc("error of the last period")] = 0.0
    total: Annotated[float, Doc("sum of the error times the period")] = 0.0
    output: Annotated[float, Doc("the last output")] = 0.0
    last: Annotated[float, Doc("last output of the system, before scaling")] = float("nan")
    started: Annotated[bool, Doc("whether a period has passed: the first error has no change")] = False


@entry_point
def controller(
    system: System,
    inputs: Mapping[str, Any] | None = None,
    *,
    output: str | None = None,
    output_scale: float = 1.0,
    incremental: bool = False,
    command: str = "",
    feedback: str = "",
    **more: Any,
) -> Block:
    """A fuzzy system as a controller block.

    Args:
        system: the system.
        inputs: where each input comes from: ``{"e": "error", "de": ("change", 20.0)}``; the first input is the error
            and the second its change in a period unless this says otherwise.
        output: the output that drives, the first one unless given.
        output_scale: what the output is multiplied by.
        incremental: whether the output is added to the last one.
        command: the field of the command that counts, where it has several: ``position`` of a motion; with dots where
            fields have fields.
        feedback: the same of the feedback.
        more: further fields of the block: ``unit``, ``drive``, ``name`` and so on.

    Its parameters are the scales by name (``scale_e``, ``scale_de``, ``scale_output``) and ``tables``, the numbers of
    the system. The change is taken from the error before scaling.

    Raises:
        NameUnknown: no such input, output or signal.
        ValueRefused: an input without a source, or a field that cannot be one.
    """
    for what, field in (("command", command), ("feedback", feedback)):
        if field and not all(part.isidentifier() and not iskeyword(part) for part in field.split(".")):
            raise ValueRefused(f"{what} = {field!r}: expected the name of a field, such as 'position'")
    sources, made = _mapping(system, inputs), engine(system)
    names = [o.name for o in system.outputs]
    wanted = names[0] if output is None else output
    if wanted not in names:
        raise NameUnknown(f"system {system.name} has no output {wanted!r}{nearest(wanted, names)}")
    params, plan = _types(made, sources)
    step = _step(made, sources, wanted, incremental, (command, feedback))
    values = {f"scale_{made.writer.names[n]}": s.scale for n, s in sources.items()}
    values["scale_output"] = output_scale

    def prepare(p: Any, dt: float) -> Any:
        scales = p._asdict()
        numbers = scales.pop("tables")
        return plan(**scales, plan=made.prepared(numbers))

    more.setdefault("name", step.__name__)
    more.setdefault("doc", system.doc or f"The fuzzy system {system.name}.")
    fields = (f"command.{command}".rstrip("."), f"feedback.{feedback}".rstrip("."))
    ranges = tuple(
        InputRange(v.name, sources[v.name].source, f"scale_{made.writer.names[v.name]}", v.low, v.high, *fields)
        for v in system.inputs
        if v.enabled
    )
    start = params(**values, tables=made.numbers)
    return make("controller", step, start, Memory(), prepare=prepare, input_ranges=ranges, **more)


@entry_point
def from_file(path: str | Path, output: str | None = None, *, command: str = "", feedback: str = "") -> Block:
    """The system in a file as a controller: its first input is the error, its second the error's change in a period.

    ``output`` is the output that drives; it may be left out where there is one. ``command`` and ``feedback`` are the
    fields that count, as for :func:`controller`. What the reader of the file has to say stands in the block's
    description.

    Raises:
        DataError: it cannot be read, or is broken; says where.
        NameUnknown: there is no such output.
        ValueRefused: more inputs than two, several outputs and none named, something that cannot be evaluated.
    """
    from leadscrew.fuzzy import formats

    system = formats.read(path)
    inputs, outputs = [v.name for v in system.inputs], [o.name for o in system.outputs]
    if not 1 <= len(inputs) <= 2:
        raise ValueRefused(
            f"{path} has {len(inputs)} inputs ({', '.join(inputs)}); a controller from a file takes the error and its "
            "change: for anything else make the block in Python, with leadscrew.fuzzy.block.controller"
        )
    if not outputs or (output is None and len(outputs) > 1):
        raise ValueRefused(f"{path}: say which output drives, as {path}:NAME; it has {', '.join(outputs) or 'none'}")
    told = " ".join(f"{_sentence(note)}." for note in system.notes)
    doc = "\n\n".join(part for part in (system.doc or f"The fuzzy system {system.name}.", told) if part)
    try:
        return controller(system, output=output or None, command=command, feedback=feedback, doc=doc)
    except (NameUnknown, ValueRefused) as error:
        raise type(error)(f"{path}: {error}") from error


def _sentence(note: str) -> str:
    return note[:1].upper() + note[1:].rstrip(".")


def _types(made: Engine, sources: Mapping[str, Scaled]) -> tuple[Any, Any]:
    """The types of the parameters and of what is prepared from them."""
    scales = [
        (f"scale_{made.writer.names[n]}", Annotated[float, Doc(f"{s.source} to {n}")]) for n, s in sources.items()
    ]
    scales.append(("scale_output", Annotated[float, Doc("what the system's output is multiplied by")]))
    params = NamedTuple("FuzzyParams", [*scales, ("tables", Tables)])  # type: ignore[misc]
    plan = NamedTuple("FuzzyPlan", [*scales, ("plan", made.plan_type)])  # type: ignore[misc]
    return params, plan


def _step(
    made: Engine, sources: Mapping[str, Scaled], wanted: str, incremental: bool, fields: tuple[str, str]
) -> Callable[..., Any]:
    """The step of the block, written for its sources and for the fields of command and feedback that count."""
    writer, system = made.writer, made.system
    signals = {
        k: ".".join([k, field] if field else [k]) for k, field in zip(("command", "feedback"), fields, strict=True)
    }
    taken_from = {**SIGNALS, **signals}
    given = [f"p.scale_{writer.names[n]} * ({taken_from[s.source]})" for n, s in sources.items()]
    locked = [o.name for o in writer.live if o.lock_previous]
    if any(n != wanted for n in locked):
        raise ValueRefused(f"system {system.name}: a controller block keeps the last value of {wanted} only")
    outputs = [f"y_{i}" for i in range(len(system.outputs))]
    y = outputs[[o.name for o in system.outputs].index(wanted)]
    taken = ", ".join(["p.plan", *given, *(["s.last"] if locked else [])])
    name = identifiers([system.name or "fuzzy"], made.space)[system.name or "fuzzy"]
    lines = [
        f"def {name}(p, s, command, feedback, dt):",
        f'    """The fuzzy system {python_docstring(system.name)} as a controller."""',
        f"    error = {signals['command']} - {signals['feedback']}",
        "    before = s.before if s.started else error",
        "    total = s.total + error * dt",
        f"    {', '.join(outputs)} = infer({taken})",
        f"    output = {'s.output + ' if incremental else ''}p.scale_output * {y}",
        f"    return Memory(error, total, output, {y}, True), output",
    ]
    text = "\n".join(lines) + "\n"
    made_step: Callable[..., Any] = execute(text, f"{system.name} block", {**made.space, "Memory": Memory})[name]
    return made_step
