"""What a machine file says of an axis before a test: values, sensor, limits, and what its log did not tell."""

from __future__ import annotations

import math
from pathlib import Path

from leadscrew.identify.excite.belief import KEYS, SIDES, Belief
from leadscrew.identify.excite.limits import Limits
from leadscrew.kernel.errors import DataError
from leadscrew.machine.file import MachineFile

TOLD, LITTLE = 0.25, 0.01
"""Half of an interval as a share of the value, and of the sliding force, up to which a parameter counts as told."""


def of_machine(path: str | Path) -> tuple[Belief, Limits]:
    """The belief, its ``wanted`` being what the log of the machine did not tell, and the limits of that log.

    Raises:
        DataError: no machine file, one without mass and friction, or a value that is no number.
    """
    from leadscrew.machine.file import read
    from leadscrew.machine.gains import per_si

    machine = read(path)
    if machine.model == "linear":
        raise DataError(
            f"{path}: is a linear machine, without mass and friction: identify the axis of its log, "
            "leadscrew identify axis LOG --out axis.toml"
        )
    scale, values = per_si(machine), _values(machine, path)
    low, high = machine.travel
    limits = Limits(low / scale, high / scale, machine.speed / scale, machine.acceleration / scale)
    rotary = machine.position_unit in ("rad", "mrad", "deg")
    symmetric = machine.identified.get("symmetric", _alike(values))
    belief = Belief(
        values, math.hypot(machine.noise, machine.resolution / math.sqrt(12.0)) / scale, machine.period,
        bool(symmetric), _force_noise(machine), "rad" if rotary else "m",
        _force_unit(machine, rotary), _missing(machine, values, bool(symmetric), limits.speed),
        _told(machine, limits.speed), machine.drive_unit,
    )  # fmt: skip
    return belief, limits


def _values(machine: MachineFile, path: str | Path) -> dict[str, float]:
    found = {}
    for key, value in {**machine.parameters, "delay_s": machine.delay_s}.items():
        if key in KEYS:
            if isinstance(value, bool) or not isinstance(value, int | float):
                raise DataError(f"{path}: set.{key} = {value!r}: expected a number")
            found[key] = float(value)
    for side in SIDES:
        # Without a rise towards rest the speed of the rise is a number that says nothing.
        if found.get(f"friction.{side}.static", 0.0) <= found.get(f"friction.{side}.coulomb", 0.0):
            found.pop(f"friction.{side}.stribeck_speed", None)
    return found


def _alike(values: dict[str, float]) -> bool:
    names = {k.rsplit(".", 1)[-1] for k in values if k.startswith("friction.forward.")}
    return all(values.get(f"friction.forward.{n}") == values.get(f"friction.backward.{n}") for n in names)


def _force_unit(machine: MachineFile, rotary: bool) -> str:
    """Where no force of the drive was told, its own unit stands for it."""
    known = machine.drive_unit in ("N", "N m") or machine.parameters.get("force_per_drive", 1.0) != 1.0
    return ("N m" if rotary else "N") if known else machine.drive_unit


def _force_noise(machine: MachineFile) -> float:
    """What the model left of the force on the log that it was fitted to; 0 where the file does not say."""
    training = machine.identified.get("training", {})
    found = training.get("rms_force", 0.0) if isinstance(training, dict) else 0.0
    return float(found) if isinstance(found, int | float) and found > 0.0 else 0.0


def _missing(machine: MachineFile, values: dict[str, float], symmetric: bool, speed: float) -> tuple[str, ...]:
    """Keys that its log fixed or told too widely, in the order of :data:`KEYS`; not those that no motion tells."""
    from leadscrew.toml_file import flat

    fixed = machine.identified.get("fixed", {})
    reasons = dict(flat(fixed)) if isinstance(fixed, dict) else {}
    beyond = {"backlash"} | (set() if symmetric else {"offset"})
    wide = {k for k in machine.intervals if not _narrow(machine, k, speed)}
    open_to = ({k for k, why in reasons.items() if why != "given"} | wide) - beyond
    return tuple(k for k in KEYS if k in open_to and (k in values or k.startswith("friction.")))


def _told(machine: MachineFile, speed: float) -> dict[str, float]:
    """Standard deviations of what its log has told."""
    return {k: (high - low) / 3.92 for k, (low, high) in machine.intervals.items()
            if k in KEYS and high > low and _narrow(machine, k, speed)}  # fmt: skip


def _narrow(machine: MachineFile, key: str, speed: float) -> bool:
    """Whether an interval is of use: narrow beside its value, or of little force beside that of sliding."""
    low, high = machine.intervals[key]
    half, value = 0.5 * (high - low), float(machine.parameters.get(key, machine.delay_s if key == "delay_s" else 0.0))
    if half <= TOLD * abs(value) or (key == "delay_s" and half <= TOLD * machine.period):
        return True
    name = key.rsplit(".", 1)[-1]
    if name not in ("offset", "coulomb", "viscous"):
        return False
    sliding = max(
        float(machine.parameters.get(f"friction.{s}.coulomb", 0.0))
        + speed * float(machine.parameters.get(f"friction.{s}.viscous", 0.0))
        for s in SIDES
    )
    return half * (speed if name == "viscous" else 1.0) <= LITTLE * sliding
