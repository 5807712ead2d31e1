"""The study of a machine file: its controllers, its scenarios and its loops, for every command that takes a study."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from leadscrew.kernel.block import Block
from leadscrew.kernel.metrics import max_error, overshoot, rms_error, settling_time
from leadscrew.kernel.parameters import checked_replace
from leadscrew.machine import gains
from leadscrew.machine.file import MachineFile, read
from leadscrew.machine.scenarios import Load, Move, Played, StepMove, command, load, logged, position_of, scenarios
from leadscrew.study_data import Scenario, Study
from leadscrew.util.errors import DataError, LeadscrewError, entry_point

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

FINE = 10
"""Integration steps a period of an axis with bristles or a Stribeck curve, or with a delay that is no whole number of
periods."""
DRIVES = {"V": "voltage", "N m": "torque", "A": "current", "N": "force"}
AXES = ("servo_axis", "servo_axis_lugre")


@entry_point
def study(path: str | Path) -> Study:
    """The study of a machine file.

    Raises:
        DataError: the file is malformed, or its numbers do not fit its model; names file and key.
    """
    where = Path(path).expanduser().resolve()
    machine = read(where)
    try:
        axis, controllers = plant_of(machine), controllers_of(machine)
        asked = scenarios(machine)
        if machine.log:
            seconds = float(machine.identified.get("seconds", 10.0))
            asked["log"] = Scenario("log", Played(), "the command of the log, again", seconds)
    except LeadscrewError as error:
        raise DataError(f"{where}: {error}") from error
    said = machine.identified.get("source")

    def build(controller: Block, scenario: Scenario) -> Loop:
        """The loop of a controller in a scenario."""
        return loop_of(machine, axis, controller, scenario)

    return Study(
        name=machine.name, title=f"The axis {machine.name}, as in {where.name}",
        paper=f"Identified from {said}." if said else "", controllers=controllers, scenarios=asked,
        build=build, folder=where.parent,
        summary=f"{machine.model}, {machine.drive_unit} to {machine.position_unit}, {machine.period:g} s a period",
    )  # fmt: skip


def left_open(path: str | Path) -> list[str]:
    """What the log of a machine leaves open, as ``--over`` takes it: each parameter over its 95 % interval.

    Raises:
        DataError: no machine file, or one without intervals.
    """
    machine = read(path)
    keys = [k for k in machine.intervals if k in machine.parameters]
    if not keys:
        raise DataError(f"{path}: has no [interval] of a parameter of its plant: name the keys, as --over KEY=LOW:HIGH")
    return [f"plant.{k}={machine.intervals[k][0]!r}:{machine.intervals[k][1]!r}" for k in keys]


def plant_of(machine: MachineFile) -> Block:
    """The plant with the machine's parameters.

    Raises:
        LeadscrewError: parameters that it does not have, or out of range.
    """
    from leadscrew import catalogue

    if machine.model == "linear":
        from leadscrew.plants._linear import transfer_function

        for key in ("numerator", "denominator"):
            if not isinstance(machine.parameters.get(key), list):
                raise DataError(f"set.{key} is missing: expected a list of numbers, highest power first")
        block = transfer_function(machine.parameters["numerator"], machine.parameters["denominator"], name="linear")
        return replace(block, unit=machine.position_unit)
    block = catalogue.block(machine.model)
    for key in ("mass", "force_per_drive"):
        if key not in machine.parameters:
            raise DataError(f"set.{key} is missing")
    if not float(machine.parameters["force_per_drive"]) > 0.0:
        raise DataError(f"set.force_per_drive = {machine.parameters['force_per_drive']!r}: expected a number above 0")
    params = checked_replace(
        block.params, {**machine.parameters, "per_si": gains.per_si(machine)}, where=f"set ({machine.model})"
    )
    return replace(block, params=params, unit=machine.position_unit)


def controllers_of(machine: MachineFile) -> dict[str, Block]:
    """Controllers for the machine: ours with and without its model, and the one that made the log, if it is known."""
    if machine.model == "linear":
        from leadscrew.controllers._pid import pid

        return {
            "ours.pid": _driving(
                pid(**gains.pid(machine)._asdict(), lower=-machine.drive, upper=machine.drive), machine
            )
        }
    from leadscrew.controllers._axis_cascade import AxisModel, axis_cascade

    p, scale = machine.parameters, gains.per_si(machine)
    force = float(p["force_per_drive"])
    sides = [float(p.get(f"friction.{side}.viscous", 0.0)) for side in ("forward", "backward")]
    model = AxisModel(
        acceleration=float(p["mass"]) / (force * scale), viscous=0.5 * sum(sides) / (force * scale),
        coulomb_forward=float(p.get("friction.forward.coulomb", 0.0)) / force,
        coulomb_backward=float(p.get("friction.backward.coulomb", 0.0)) / force,
        offset=float(p.get("offset", 0.0)) / force, smooth=max(5e-3 * machine.speed, 1e-9),
    )  # fmt: skip
    common: dict[str, Any] = {f"model.{key}": value for key, value in model._asdict().items()}
    common |= {
        "lower": -machine.drive,
        "upper": machine.drive,
        "ahead_s": min(machine.delay_s + 0.5 * machine.period, 0.1),
    }
    first = gains.cascade(machine)._asdict()
    found = {
        "ours.cascade": replace(
            axis_cascade(**first, **common, velocity_share=1.0),
            doc="Position loop P around a speed loop PI, gains from mass, delay, encoder and noise.",
        ),
        "ours.cascade_model": replace(
            axis_cascade(**first, **common, velocity_share=1.0, model_share=1.0),
            doc="The same, with inertia, friction and offset of the machine fed forward.",
        ),
    }
    if machine.cascade:
        logged = {"kpos": machine.cascade.get("kp", 0.0), "kvp": machine.cascade.get("kv", 0.0)}
        logged["kvi"] = machine.cascade.get("ki", 0.0)
        logged_law = axis_cascade.using(**logged, **common)
        found["logged.cascade"] = replace(
            logged_law, doc="The controller that made the log, its speed over one period."
        )
    return {name: _driving(block, machine) for name, block in found.items()}


def _driving(block: Block, machine: MachineFile) -> Block:
    """The controller, in the machine's drive."""
    return replace(block, unit=machine.drive_unit, drive=DRIVES.get(machine.drive_unit, ""), full_scale=machine.drive)


def metrics_of(scenario: Scenario) -> dict[str, Block]:
    """What a run is judged by, in the machine's unit."""
    found = {"rms_error": rms_error, "max_error": max_error}
    if isinstance(scenario.params, Move):
        return {**found, "settling": settling_time(percent=0.0, band=1e-3 * abs(scenario.params.distance))}
    if isinstance(scenario.params, StepMove):
        return {"overshoot": overshoot, "settling": settling_time(percent=5.0), **found}
    return found if isinstance(scenario.params, Load) else {n: m(from_time=1.0) for n, m in found.items()}


@lru_cache(maxsize=8)
def _steps(period: float, delay: float, curved: bool) -> int:
    """Integration steps a period, so that the delay is a whole number of them as nearly as may be."""
    whole = abs(delay / period - round(delay / period)) < 0.02
    return FINE if curved or not whole else 1


def _curved(machine: MachineFile) -> bool:
    """Whether friction falls from static to Coulomb friction, or bends: both want short steps."""
    p = machine.parameters
    sides = [f"friction.{side}" for side in ("forward", "backward")]
    falls = any(float(p.get(f"{s}.static", 0.0)) > float(p.get(f"{s}.coulomb", 0.0)) for s in sides)
    return falls or machine.model == "servo_axis_lugre"


def loop_of(machine: MachineFile, axis: Block, controller: Block, scenario: Scenario) -> Loop:
    """The loop of a controller in a scenario on this machine.

    The delay is taken to the nearest integration step; the sensor reads the table with the machine's encoder and noise.
    """
    from leadscrew.actuators._saturation import saturation
    from leadscrew.controllers._wrapping import takes_motion
    from leadscrew.kernel.loop import Loop

    steps = _steps(machine.period, machine.delay_s, _curved(machine))
    step = machine.period / steps
    options: dict[str, Any] = {"method": "sdirk3"} if machine.model == "servo_axis_lugre" else {}
    motion = takes_motion(controller, machine.period)
    if isinstance(scenario.params, Played):
        reference = logged(machine) if motion else position_of(logged(machine))
    else:
        reference = command(scenario.params, motion, machine.position_unit)
    return Loop(
        reference=reference, controller=controller,
        plant=axis, sensor=_sensor(machine), disturbance=load(scenario.params),
        actuator=saturation(lower=-machine.drive, upper=machine.drive), period=machine.period, substeps=steps,
        computation_delay=round(machine.delay_s / step) * step, metrics=metrics_of(scenario),
        bound=1e3 * max(abs(math.dist((machine.travel[0],), (machine.travel[1],))), 1e-9), **options,
    )  # fmt: skip


def _sensor(machine: MachineFile) -> Block | None:
    if machine.model in AXES:
        from leadscrew.sensors._counts import axis_reading

        return axis_reading(resolution=machine.resolution, noise=machine.noise)
    if not machine.resolution and not machine.noise:
        return None
    from leadscrew.sensors._counts import noisy_ruler

    return noisy_ruler(resolution_mm=machine.resolution or 1e-9, noise_mm=machine.noise)
