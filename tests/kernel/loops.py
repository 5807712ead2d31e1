"""A loop around any block of the catalogue, and random parameters for it."""

from typing import NamedTuple

import numpy as np

from leadscrew import catalogue, resolve
from leadscrew.actuators._dac import lathe_dac
from leadscrew.actuators._saturation import saturation
from leadscrew.controllers._sliding.continuous import seen_in_mm
from leadscrew.disturbances._cut_load import cut_load
from leadscrew.kernel.block import Block, controller
from leadscrew.kernel.loop import Loop
from leadscrew.plants._ballscrew_stage import ballscrew_stage
from leadscrew.plants._flexible_cut import flexible_cut
from leadscrew.plants._turning import turning
from leadscrew.plants._turning_lathe import turning_lathe
from leadscrew.references._cut_line import along, cut_line
from leadscrew.references._cutting_program import cutting_force, cutting_program
from leadscrew.references._lathe_program import LatheDrive, lathe_program
from leadscrew.references._sine import sine, sine_motion
from leadscrew.sensors._cut_camera import cut_reading
from leadscrew.sensors._lathe_sensors import lathe_sensors
from leadscrew.sensors._load_cell import lathe_reading, load_cell
from leadscrew.util.errors import LeadscrewError
from tests.kernel import zoo


class GainParams(NamedTuple):
    gain: float = 0.8


@controller(GainParams())
def follows_motion(p, command, feedback):
    return p.gain * (command.position - feedback)


@controller(GainParams())
def follows_position(p, command, feedback):
    return p.gain * (command - feedback.position)


@controller(GainParams())
def follows_force(p, command, feedback):
    return 0.003 * p.gain * (command + 150.0 - feedback.force)


@controller(GainParams())
def follows_cut(p, command, feedback):
    return 0.003 * p.gain * (command.force - feedback.force)


@controller(GainParams())
def drives_lathe(p, command, feedback):
    feed = 0.003 * p.gain * (command.force - feedback.force)
    return LatheDrive(8.0 + 0.001 * (command.rpm - feedback.rpm), feed, 3.0 * (command.depth - feedback.depth))


@controller(GainParams())
def turns_blade(p, command, feedback):
    return 20.0 * p.gain * command.curvature_ahead - 0.1 * p.gain * (feedback.deviation - command.deviation)


PERIOD = 1e-3
COMMANDS = (sine(amplitude=3.0, frequency=0.7), sine_motion(amplitude=3.0, frequency=0.7))
CONTROLLERS = (zoo.pid(kp=0.8), follows_motion, follows_position, follows_force)
CUT = {"reference": cutting_program, "controller": follows_cut, "plant": turning, "sensor": lathe_reading}
"""A lathe in the cut, for blocks on its signals."""
LATHE = {
    "reference": lathe_program, "controller": drives_lathe, "plant": turning_lathe, "sensor": lathe_sensors,
    "actuator": lathe_dac,
}  # fmt: skip
"""The whole lathe."""
WAY = np.linspace(0.0, 100.0, 500)
CURVED = 90.0 * np.sin(WAY / 15.0), np.radians(6.0 * np.cos(WAY / 15.0))
KNIFE = {
    "reference": along(cut_line, *CURVED), "controller": turns_blade, "plant": flexible_cut, "sensor": cut_reading,
    "disturbance": along(cut_load, *CURVED),
}  # fmt: skip
"""A tangential knife on a curved line."""


def _candidates(block: Block):
    """Loops that a block may fit into, the plainest first."""
    rest = {"period": PERIOD, "actuator": saturation(lower=-100.0, upper=100.0), "metrics": {}}
    if block.kind == "reference":
        for c in CONTROLLERS:
            yield {"reference": block, "controller": c, "plant": zoo.mass, **rest}
        yield {**CUT, "reference": block, **rest}
        yield {**KNIFE, "reference": block, **rest}
    elif block.kind == "controller" and block.continuous:
        stage = seen_in_mm(ballscrew_stage)
        parts = {"reference": COMMANDS[1], "controller": block, "plant": stage, "metrics": {}}
        yield {**parts, "period": None, "sample": PERIOD, "atol": 1e-11}
    elif block.kind == "controller":
        for command in COMMANDS:
            yield {"reference": command, "controller": block, "plant": zoo.mass, **rest}
        yield {**CUT, "controller": block, **rest}
        yield {**KNIFE, "controller": block, **rest, "period": 0.01}
        cut = {"reference": cutting_force, "plant": turning, "sensor": load_cell, "metrics": {}}
        yield {**cut, "controller": block, "period": 0.02, "substeps": 20}
    elif block.kind == "plant":
        for c in CONTROLLERS:
            for method in ("rk4", "sdirk3"):
                yield {"reference": COMMANDS[0], "controller": c, "plant": block, "method": method, **rest}
        yield {**rest, **LATHE, "plant": block}
        yield {**rest, **KNIFE, "plant": block}
    elif block.kind == "metric":
        yield {
            "reference": COMMANDS[0],
            "controller": CONTROLLERS[0],
            "plant": zoo.mass,
            **rest,
            "metrics": {"it": block},
        }
    else:
        plain = {"reference": COMMANDS[0], "controller": CONTROLLERS[0], "plant": zoo.mass, **rest}
        yield {**plain, block.kind: block}
        plants = [resolve.block(n) for n in catalogue.block_names() if resolve.block(n).kind == "plant"]
        for plant in plants:
            yield {**plain, "plant": plant, block.kind: block}
        for c in CONTROLLERS:
            yield {**plain, "plant": turning, "controller": c, block.kind: block}
        yield {**rest, **LATHE, block.kind: block}
        yield {**rest, **KNIFE, block.kind: block}
        yield {**rest, **KNIFE, "controller": CONTROLLERS[0], "reference": COMMANDS[0], block.kind: block}


def around(name: str) -> Loop:
    """A loop with a block of the catalogue in its place."""
    block = resolve.block(name)
    said = []
    for parts in _candidates(block):
        try:
            loop = Loop(**parts, name=name)
            loop.program  # noqa: B018
            return loop
        except LeadscrewError as error:
            said.append(str(error))
    raise AssertionError(f"{name} fits into no loop: {said}")


def varied(loop: Loop, rng: np.random.Generator) -> Loop:
    """The loop with every number of every block moved by up to 20 %, where its data sheet and its block allow it."""
    for key, entry in loop.sheet.items():
        if entry.type not in ("float", "array"):
            continue
        value = entry.default * (1.0 + 0.2 * rng.uniform(-1.0, 1.0, np.shape(entry.default)))
        try:
            moved = loop.using({key: np.asarray(value) if entry.type == "array" else float(value)})
            moved.values()
        except LeadscrewError:
            continue
        if moved.fits(loop.program):
            loop = moved
    return loop
