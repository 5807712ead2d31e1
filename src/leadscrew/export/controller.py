"""From a loop to an exported controller: its C, its ports and knobs, and a recorded run in the loop to check it by.

A knob is a parameter that can be changed on the machine: one that reaches the step unchanged. A block that prepares its
parameters (works out filter coefficients, tables) hands its step other numbers than those of the data sheet: a
parameter is a knob where changing it changes nothing but copies of itself; else it is baked in.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.export.core import Core, Knob, Limits, Port, Record
from leadscrew.export.machine import LICENCE, machine_files
from leadscrew.export.source import Source
from leadscrew.kernel.block import DRIVES, Block
from leadscrew.kernel.c99.names import is_identifier, safe, safe_field
from leadscrew.kernel.frame import pairs
from leadscrew.kernel.layout import Layout, is_branch, numbers_of
from leadscrew.kernel.loop import Loop
from leadscrew.kernel.parameters import ParameterSpec, entries, put
from leadscrew.util.errors import BlockError, LeadscrewError, ValueRefused
from leadscrew.util.escape import c_comment, checked_line, one_line

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop


def _others(entry: ParameterSpec) -> Iterator[Any]:
    """Other values that a parameter may have, near its own."""
    value = entry.stored(entry.default)
    if entry.choice is not None:
        yield from (number for number in range(len(entry.choice.names)) if number != value)
        return
    if entry.type == "bool":
        yield not value
        return
    steps = (1, -1, 2, -2) if entry.type == "int" else (0.01, -0.01, 1e-3, -1e-3, 1e-6, -1e-6)
    if math.isinf(value):
        value = 0.0
    scale = 1 if entry.type == "int" else max(abs(value), 1e-3)
    for step in steps:
        try:
            yield entry.check(value + step * scale)
        except LeadscrewError:
            continue


def _prepared(block: Block, params: Any, period: float) -> list[float]:
    made = params if block.prepare is None else block.prepare(params, period)
    return list(numbers_of(made))


def _places(prepared: Any) -> list[str]:
    """The C place of every number of the prepared parameters, in their order; empty for elements of arrays."""
    found: list[str] = []
    for leaf in _in_order(Layout(prepared).tree):
        if leaf.kind == "array":
            found += [""] * leaf.size
        else:
            found.append(".".join(safe_field(part) for part in leaf.key.split(".")))
    return found


def _in_order(node: Any) -> Iterator[Any]:
    for part in getattr(node, "parts", ()):
        if hasattr(part, "parts"):
            yield from _in_order(part)
        else:
            yield part


def _carried(block: Block, entry: ParameterSpec, period: float, places: list[str]) -> tuple[str, ...]:
    """Where a parameter's own value lies among the prepared ones; empty where it is worked into others."""
    base, own = _prepared(block, block.params, period), entry.stored(entry.default)
    found: set[int] | None = None
    tried = 0
    for value in _others(entry):
        try:
            moved = _prepared(block, put(block.params, entry.key.split("."), value), period)
        except LeadscrewError:
            continue
        if len(moved) != len(base):
            return ()
        changed = {i for i, (a, b) in enumerate(zip(base, moved, strict=True)) if a != b}
        if not changed or any(moved[i] != value or base[i] != own or not places[i] for i in changed):
            return ()
        found = changed if found is None else found
        if changed != found:
            return ()
        tried += 1
        if tried == 2:
            break
    return tuple(places[i] for i in sorted(found or ()))


def named_options(name: str, knobs: Iterable[Knob]) -> str:
    """The options of choices as constants of C, ``NAME_KNOB_OPTION``."""
    parts, taken = [], set[str]()
    for knob in knobs:
        rows = []
        for number, option in enumerate(knob.names):
            constant = safe(f"{name}_{knob.name}_{option}".replace("-", "_").upper(), taken)
            taken.add(constant)
            rows.append(f"    {constant} = {number}")
        if rows:
            parts.append(
                f"/* params.{knob.places[0]}: {c_comment(knob.doc)} */\nenum {{\n" + ",\n".join(rows) + "\n};\n"
            )
    return "\n".join(parts)


def knobs_of(block: Block, prepared: Any, period: float) -> tuple[tuple[Knob, ...], tuple[str, ...]]:
    """The knobs of a block, and the keys of the parameters that are none (arrays among them)."""
    if block.params is None:
        return (), ()
    places = _places(prepared)
    knobs: list[Knob] = []
    baked: list[str] = []
    taken: set[str] = set()
    for entry in entries(block.params):
        where = () if entry.type == "array" else _carried(block, entry, period, places)
        if not where:
            baked.append(entry.key)
            continue
        name = safe(entry.key.replace(".", "_"), taken)
        taken.add(name)
        low = -math.inf if entry.above == -math.inf else entry.above
        choice = entry.choice
        if choice is not None:
            knobs.append(
                Knob(
                    entry.key, name, "choice", entry.stored(entry.default), where, entry.unit, entry.doc, 0,
                    len(choice.names) - 1, str(choice), choice.names,
                )
            )  # fmt: skip
            continue
        knobs.append(
            Knob(
                entry.key, name, entry.type, entry.default, where, entry.unit, entry.doc, low, entry.below, entry.range
            )
        )
    return tuple(knobs), tuple(baked)


REALS = ("double", "float")
ROLES = {"velocity": "command-deriv", "acceleration": "command-accel"}
LONGEST_NAME = 25
"""LinuxCNC has 47 characters for a name like ``NAME.0.max-following-error``."""


def checked_name(name: str) -> str:
    """A name for the exported files.

    Raises:
        ValueRefused: not an identifier of C, a keyword, or too long.
    """
    hint = f"choose another, for example --name {name}_controller"
    if not name.isidentifier() or not name.isascii() or name.startswith("_"):
        raise ValueRefused(f"name = {name!r}: allowed are letters, digits and underscores, a letter first")
    if not is_identifier(name):
        raise ValueRefused(f"name = {name!r} is a word of the C language or its library; {hint}")
    if name.lower() == "check" or name.lower().startswith(("fmi2", "fmi3")):
        raise ValueRefused(f"name = {name!r} is the name of another file of an export; {hint}")
    if len(name) > LONGEST_NAME:
        raise ValueRefused(
            f"name = {name!r} has {len(name)} characters; at most {LONGEST_NAME} are allowed: use --name"
        )
    return name


def drive_of(block: Block, wanted: str | None) -> str:
    """What the controller's output commands.

    Raises:
        ValueRefused: the machine's drive is another, or none of the known ones.
    """
    if wanted is None:
        return block.drive
    if wanted not in DRIVES:
        raise ValueRefused(f"drive = {wanted!r}: there are {', '.join(DRIVES)}")
    if block.drive and block.drive != wanted:
        unit = f" {block.unit}" if block.unit not in ("", "1") else ""
        scale = f" (full scale {block.full_scale:g}{unit})" if block.full_scale else ""
        raise ValueRefused(
            f"drive = {wanted!r}: {block.name} commands {block.drive}{scale}; "
            "choose a controller made for this drive, or put an amplifier's model between"
        )
    return wanted


def _role(key: str, first: dict[str, str]) -> str:
    if key in first:
        return first[key]
    signal, *rest = key.split(".")
    return ROLES.get(rest[-1], "other") if rest and signal == "command" else "other"


def _unit(loop: Loop, block: Block, role: str) -> str:
    plant = loop.blocks["plant"]
    base = plant.unit if plant is not None else ""
    if role == "output":
        return block.unit
    return {"command-deriv": f"{base}/s", "command-accel": f"{base}/s^2"}.get(role, base) if base else ""


DOCS = {
    "command": "where the axis is to be", "feedback": "where the axis is, as measured",
    "command-deriv": "time derivative of the command", "command-accel": "second time derivative of the command",
    "output": "to the drive",
}  # fmt: skip


def _annotated(signal: str, example: Any) -> list[ParameterSpec]:
    """What the annotations of a signal's NamedTuple say of its numbers."""
    return list(entries(example, f"{signal}.")) if is_branch(example) else []


def _start(loop: Loop, key: str) -> float:
    """The default of a signal's number in its NamedTuple; 0 where it has none."""
    signal, *path = key.split(".")
    node = loop.signals[signal]
    for field in path[:-1]:
        node = getattr(node, field)
    value = type(node)._field_defaults.get(path[-1], 0.0) if path and is_branch(node) else 0.0
    return float(value) if math.isfinite(value) else 0.0


def ports(loop: Loop, block: Block, source: Source) -> tuple[tuple[Port, ...], tuple[Port, ...]]:
    """Inputs and outputs of a controller in a loop."""
    pair = pairs(source.tree("command"), source.tree("feedback"))[0]
    first = {
        f"command.{pair.command}".rstrip("."): "command",
        f"feedback.{pair.other}".rstrip("."): "feedback",
    }

    said = {e.key: e for s in ("command", "feedback", "output") for e in _annotated(s, loop.signals[s])}

    def port(argument: Any, role: str) -> Port:
        entry = said.get(argument.key)
        described = entry is not None and bool(entry.doc)  # then no unit means a pure number
        unit = entry.unit if entry and (entry.unit or (role == "other" and described)) else _unit(loop, block, role)
        doc = DOCS.get(role, entry.doc if entry and entry.doc else argument.key)
        start = 0.0 if role in DOCS else _start(loop, argument.key)
        return Port(argument.key, argument.name, role, one_line(unit), doc, start)

    inputs = tuple(port(a, _role(a.key, first)) for a in source.inputs)
    return inputs, tuple(port(o, "output") for o in source.outputs)


def rounded_up(value: float) -> float:
    """A positive number rounded up to two digits."""
    if value <= 0.0:
        return 0.0
    scale = 10.0 ** (math.floor(math.log10(value)) - 1)
    return float(f"{math.ceil(value / scale) * scale:.6g}")


def limits_of(core: Core, record: Record) -> Limits:
    """Limits for the machine: full scale, twice the record's following error, and its way against the output.

    The way against the output is what the machine layer counts: how far the feedback goes against an output that
    should close the error, without slowing down. Allowed is twice what the record has and a twentieth of its
    following error more, and no less than a hundred of the feedback's smallest steps: noise is no fault.
    """
    at = {p.role: i for i, p in enumerate(core.inputs)}
    command, feedback = record.inputs[:, at["command"]], record.inputs[:, at["feedback"]]
    error = command - feedback
    output = record.outputs[:, 0] * core.sense
    worst = way = last = 0.0
    for k in range(1, len(error)):
        move = feedback[k] - feedback[k - 1]
        if move != 0:
            closing = output[k - 1] != 0 and (output[k - 1] > 0) == (error[k] > 0)
            if not closing or (move > 0) == (error[k] > 0):
                way = 0.0
            elif abs(move) >= abs(last):
                way += abs(move)
            worst = max(worst, way)
        last = move
    largest = float(np.max(np.abs(error), initial=0.0))
    steps = np.abs(np.diff(feedback))
    count = float(np.min(steps[steps > 0.0], initial=np.inf))
    floor = 100.0 * count if np.isfinite(count) else 0.0
    return Limits(core.full_scale, rounded_up(2.0 * largest), rounded_up(max(2.0 * worst + 0.05 * largest, floor)))


def recorded(loop: Loop, source: Source, duration: float) -> Record:
    """A run of the loop: what its controller took and gave in every period.

    Raises:
        ValueRefused: the loop diverges, so that there is nothing to check an export by.
    """
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        run = loop.run(duration, record=("command", "feedback", "output"), every=1)
    if run.diverged is not None:
        raise ValueRefused(f"{loop.name} {run.diverged}; an export is checked by a run of its loop, which must hold")
    inputs = np.column_stack([run.signals[a.key] for a in source.inputs])
    outputs = np.column_stack([run.signals[o.key] for o in source.outputs])
    return Record(inputs, outputs)


def _depends_on_period(block: Block, period: float) -> bool:
    if block.prepare is None:
        return False
    both = [list(numbers_of(block.prepare(block.params, dt))) for dt in (period, 1.01 * period)]
    return both[0] != both[1]


NO_LIMIT = {"double": 1e308, "float": 1e38}
"""What stands in an export for a limit at infinity: HAL and FMI take finite parameters only."""


def _with_finite_parameters(loop: Loop, real: str) -> Loop:
    """The loop, with a number beyond all others in the place of infinite parameters of its controller."""
    return loop.using(
        {
            key: math.copysign(NO_LIMIT[real], value)
            for key, value in loop.parameters.items()
            if key.startswith("controller.") and isinstance(value, float) and math.isinf(value)
        }
    )


def export_controller(
    loop: Loop, duration: float, *, name: str, title: str, real: str = "double", drive: str | None = None
) -> tuple[Core, Record]:
    """The controller of a loop as C99, and a run of the loop by which every target is checked.

    Args:
        loop: the closed loop; its controller is exported with the parameters that it has there.
        duration: seconds of the run that becomes the golden vectors.
        name: stem of the C names, an identifier.
        title: how the controller is called in texts.
        real: ``double`` or ``float``.
        drive: what the machine's drive takes; refused where the controller commands something else.

    Raises:
        SubsetError: a construct that cannot be translated, by file and line.
        ValueRefused: a bad name, drive or number type; a loop that diverges.
        BlockError: a loop without a control period.
    """
    if real not in REALS:
        raise ValueRefused(f"real = {real!r}: there are {', '.join(REALS)}")
    loop = _with_finite_parameters(loop, real)
    block, plant = loop.blocks["controller"], loop.blocks["plant"]
    assert block is not None and plant is not None
    if loop.continuous or block.continuous:
        raise BlockError(f"{block.name}: a continuous loop (period=None) has no control period to run on a machine")
    checked_name(name)
    drive = drive_of(block, drive)
    prepared = None if block.params is None else loop.prepared(block, "controller")
    state = None if block.state is None else loop.start_state(block)
    title = checked_line("title", title)
    head = f"/* {c_comment(title)}, exported by Leadscrew from {c_comment(block.name)}.\n{LICENCE} */\n"
    source = Source(block, prepared, state, loop.signals, name=name, period=loop.period, real=real, head=head)
    knobs, baked = knobs_of(block, prepared, loop.period)
    files = source.files(named_options(name, knobs))
    inputs, outputs = ports(loop, block, source)
    record = recorded(loop, source, duration)
    double = record
    if real == "float":
        from leadscrew.export.single import replay

        held = record.inputs.astype(np.float32).astype(np.float64)
        record = Record(held, replay(source, held))
    core = Core(
        name=name, title=title, doc=block.doc, real=real, period=loop.period, inputs=inputs, outputs=outputs,
        knobs=knobs, baked=baked, limits=Limits(), sense=min(block.sense, plant.sense), drive=drive,
        full_scale=block.full_scale, bumpless=block.align is not None, files=files,
    )  # fmt: skip
    core = replace(core, limits=limits_of(core, record))
    core = replace(core, files={**files, **machine_files(core)})
    return replace(core, manifest=manifest(core, loop, source, record, double)), record


def manifest(core: Core, loop: Loop, source: Source, record: Record, double: Record) -> dict[str, Any]:
    """What every exported folder says of itself, in ``manifest.json``."""
    from leadscrew._version import __version__

    block = loop.blocks["controller"]
    assert block is not None
    found: dict[str, Any] = {
        "schema_version": 1,
        "leadscrew": __version__,
        "name": core.name,
        "title": core.title,
        "block": block.name,
        "loop": loop.name,
        "origin": loop.origin,
        "period_s": core.period,
        "integration": loop.integration,
        "real": core.real,
        "drive": core.drive,
        "full_scale": core.full_scale,
        "unit": block.unit,
        "sense": core.sense,
        "bumpless": core.bumpless,
        "rediscretisable": not _depends_on_period(block, core.period),
        "inputs": [vars(p) for p in core.inputs],
        "outputs": [vars(p) for p in core.outputs],
        "parameters": {e.key: e.default for e in entries(block.params)} if block.params is not None else {},
        "knobs": [{key: v for key, v in vars(k).items() if key != "names" or v} for k in core.knobs],
        "baked": list(core.baked),
        "limits": vars(core.limits),
        "source_hash": source.module.identity(),
        "seed": loop.seed,
        "cycles": len(record.outputs),
    }
    if core.real == "float":
        found["single_precision"] = {
            "largest_difference_to_double": float(np.max(np.abs(record.outputs - double.outputs), initial=0.0)),
            "unit": block.unit,
            "said": "same inputs, output in single precision against output in double precision",
        }
    return found


def identity_of(loop: Loop) -> dict[str, Any]:
    """The controller of a loop: block, parameters, period, hashes.

    ``source_hash`` is that of the steps from which C, HAL component and FMU are printed: the same as in the
    ``manifest.json`` of an export of this controller. It says nothing of the parameters; ``fingerprint`` is over both
    and the period.
    """
    from leadscrew._version import __version__
    from leadscrew.export.source import Source

    block = loop.blocks["controller"]
    assert block is not None
    prepared = None if block.params is None else loop.prepared(block, "controller")
    state = None if block.state is None else loop.start_state(block)
    source = Source(block, prepared, state, loop.signals, name="certified", period=loop.period, real="double", head="")
    source.files()
    steps = source.module.identity()
    sheet = tuple(entries(block.params))
    parameters = {e.key: e.default.tolist() if hasattr(e.default, "tolist") else e.default for e in sheet}
    numbers = {e.key: e.stored(e.default) for e in sheet if e.choice is not None}
    said = json.dumps([steps, parameters | numbers, loop.period], sort_keys=True)
    return {
        "block": block.name,
        "parameters": parameters,
        "period_s": loop.period,
        "source_hash": steps,
        "fingerprint": hashlib.sha256(said.encode()).hexdigest()[:24],
        "leadscrew": __version__,
    }
