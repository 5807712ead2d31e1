"""The profile of any other machine: a machine file, a plug-in's study, a study or a loop of one's own."""

from __future__ import annotations

from typing import TYPE_CHECKING

from leadscrew.figures.signals import factor_between, signal_unit
from leadscrew.kernel.layout import is_branch
from leadscrew.kernel.parameters import entries
from leadscrew.operate.profile import (
    Disturbance,
    Field,
    Plot,
    Profile,
    Role,
    Trace,
    load_pulse,
    moved_on,
    noise,
    to_value,
    with_blocks,
    with_pulse,
)

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

WINDOW_S = 5.0

MOST = 1e6
"""Bound of a load or a noise of which no block says how large it may be."""

FURTHER = 5.0
"""Targets that may be asked for, over the scenario's own."""

LOUDER = 10.0
"""Noise that is proposed, over what the sensor has; of one without noise the resolution, or this:"""

FAINT = 1e-4
"""Noise that is proposed where nothing says how fine the sensor is, over the distance that the command goes."""

PUSH = 0.1
"""Load pulse that is proposed, over what the drive can do; a new target, over the distance that the command goes."""

WIDEST = 4
"""Most numbers of one signal that are drawn."""

FINE = {"mm": "um", "rad": "urad", "m": "um"}
"""Units in which a machine thinks of its errors."""

LABELS = {"true_error": "true error", "error": "error as measured", "disturbance": "load"}
"""Of signals whose names say too little."""

PULSE = {"disturbance.size", "disturbance.start", "disturbance.duration"}


def profile(name: str) -> Profile:
    """The profile of a study, machine file or loop by its name, for its first controller and scenario.

    Raises:
        NameUnknown, DataError: there is no such study; the file cannot be read.
    """
    from leadscrew import resolve
    from leadscrew.experiment import Experiment
    from leadscrew.study_data import Study

    found = resolve.subject(name)
    if not isinstance(found, Study):
        return of_loop(name, None, None, Experiment(name).loop(), "A loop of one's own; its command says when it ends.")
    controller, scenario = next(iter(found.controllers)), next(iter(found.scenarios))
    seconds = found.scenario(scenario).duration_s
    words = f"{scenario} lasts {seconds:g} s; the run goes on with what its reference then gives."
    return of_loop(name, controller, scenario, Experiment(name, controller, scenario).loop(), words)


def of_loop(study: str, controller: str | None, scenario: str | None, loop: Loop, notes: str) -> Profile:
    """The profile of a loop: its signals with the units of its blocks, a pulse and noise where there is room."""
    whole = operated(loop)
    found = tuple(d for d in (_move(whole), _pulse(whole), _noise(whole)) if d is not None)
    return Profile(study, controller, scenario, WINDOW_S, plots(whole), found, operated=operated, notes=notes)


def operated(loop: Loop) -> Loop:
    """A pulse where nothing loads the plant, noise where it shows one number and nothing senses it.

    A loop in continuous time stays as it is.
    """
    from leadscrew.sensors._counts import noisy

    if loop.continuous:
        return loop
    if loop.blocks["sensor"] is None and not is_branch(loop.signals["actual"]):
        loop = with_blocks(loop, sensor=noisy)
    return with_pulse(loop)


def _move(loop: Loop) -> Disturbance | None:
    """Another target for a step or a move, at most :data:`FURTHER` times as far from 0 as the first."""
    values = loop.parameters
    step, move = "reference.target", ("reference.start", "reference.distance", "reference.start_time")
    if step in values:
        first = values[step]
    elif set(move) <= set(values):
        first = values[move[0]] + values[move[1]]
    else:
        return None
    most = FURTHER * (abs(first) or 1.0)
    new = first - PUSH * _way(loop)
    field = Field("target", "target", signal_unit(loop, "command"), -most, most, new, "where to go")
    if step in values:
        doc = "A step of the command, for this axis and for the one it is compared with."
        return to_value("go_to", "Go to", doc, step, field)
    return moved_on(move[0], move[2], field)


def _way(loop: Loop) -> float:
    """How far the command goes, and which way, as its parameters say; else 1."""
    values = loop.parameters
    known = (values.get(f"reference.{name}", 0.0) for name in ("distance", "amplitude", "target"))
    return next((x for x in known if isinstance(x, float) and x != 0.0), 1.0)


def _drive(loop: Loop) -> tuple[str, float]:
    """Unit of a load, and its size at the drive's limit: 0 where no block says it."""
    plant, law = loop.blocks["plant"], loop.blocks["controller"]
    assert plant is not None and law is not None
    if "load" not in plant.signals:
        return law.unit, law.full_scale
    force = loop.sheet.get("plant.force_per_drive")
    if force is None:
        return "", law.full_scale
    if force.default == 1.0:  # the drive's unit stands for the force, which is not known
        return law.unit, law.full_scale
    turns = signal_unit(loop, "actual") in ("rad", "deg")
    return f"{force.unit} m" if turns else force.unit, abs(force.default) * law.full_scale


def _pulse(loop: Loop) -> Disturbance | None:
    if not set(loop.sheet) >= PULSE:
        return None
    unit, full = _drive(loop)
    plant = loop.blocks["plant"]
    assert plant is not None
    if "load" in plant.signals:
        return load_pulse(unit, MOST, PUSH * full or 1.0, "A load on the plant for a while.")
    return load_pulse(unit, full or MOST, PUSH * full or 1.0, "Added to the input of the plant for a while.")


def _noise(loop: Loop) -> Disturbance | None:
    known = [e for k, e in loop.sheet.items() if k.startswith("sensor.") and e.type == "float"]
    sized = [e for e in known if "noise" in e.key or e.key == "sensor.deviation"]
    if not sized:
        return None
    where = sized[0].unit or signal_unit(loop, "actual")
    unit = FINE.get(where, where)
    factor = factor_between(where, unit)
    quiet = loop.parameters.get("sensor.resolution", 0.0) or FAINT * abs(_way(loop))
    value = min(factor * (LOUDER * sized[0].default or quiet), MOST)
    return noise(sized[0].key, unit, MOST, value, "the sensor", factor=1.0 / factor)


def plots(loop: Loop) -> tuple[Plot, ...]:
    """Command and machine, error, output and load: of each signal the numbers that have the unit of its first."""
    whole = (
        _plot(loop, "Command and machine", {"command": "command", "actual": "actual", "feedback": "feedback"}),
        _plot(loop, "Error", {"true_error": "error", "error": "other"}, fine=True),
        _plot(loop, "Output", {"output": "output", "applied": "other"}),
        _plot(loop, "Load", {"disturbance": "disturbance"}),
    )
    return tuple(plot for plot in whole if plot.traces)


def _plot(loop: Loop, title: str, roots: dict[str, Role], fine: bool = False) -> Plot:
    units = {root: _units(loop, root) for root in roots}
    shown = next((unit for found in units.values() for unit in found.values()), "")
    unit = FINE.get(shown, shown) if fine else shown
    traces = [
        Trace(column, _label(column), role)
        for root, role in roots.items()
        for column in [c for c, own in units[root].items() if own == shown][:WIDEST]
    ]
    return Plot(title, unit, tuple(traces))


def _label(column: str) -> str:
    root, _, rest = column.partition(".")
    name = LABELS.get(root, root)
    return name if rest in ("", "position") else f"{name}: {rest.replace('_', ' ').replace('.', ' ')}"


def _units(loop: Loop, root: str) -> dict[str, str]:
    """The unit of every number of a signal: what its type says, else of its position what the loop's blocks say.

    States of the load's block, which bear the same names, are left out.
    """
    example = loop.signals[{"disturbance": "load", "true_error": "actual", "error": "feedback"}.get(root, root)]
    said = {f"{root}.{e.key}": e.unit for e in entries(example)} if is_branch(example) else {}
    columns = [c for c in loop.program.plan.columns if c == root or (c in said and c.startswith(f"{root}."))]
    main = [c for c in columns if c in (root, f"{root}.position")] or columns[:1]
    found = {c: said.get(c) or (_of_block(loop, c) if c in main else None) for c in columns}
    return {c: unit for c, unit in found.items() if unit is not None}


def _of_block(loop: Loop, column: str) -> str:
    return _drive(loop)[0] if column.split(".")[0] == "disturbance" else signal_unit(loop, column)
