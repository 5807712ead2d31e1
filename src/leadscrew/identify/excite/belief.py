"""What is believed of an axis before the test: its parameters, its sensor, and what its log has to make identifiable.

From the machine file where there is one (:func:`of_machine`), else guessed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from leadscrew.identify.estimation import LITTLE, identifiable, quantile
from leadscrew.identify.excite.move import Limits
from leadscrew.kernel.parameters import nearest
from leadscrew.machine.file import MachineFile
from leadscrew.util import reading
from leadscrew.util.errors import DataError, NameUnknown, ValueRefused

SIDES = ("forward", "backward")
OF_SIDE = ("coulomb", "viscous", "static", "stribeck_speed")
KEYS = ("mass", "offset", *(f"friction.{s}.{k}" for s in SIDES for k in OF_SIDE), "friction.stiffness",
        "friction.damping", "backlash", "delay_s")  # fmt: skip
SHORT = {
    **{k: tuple(f"friction.{s}.{k}" for s in SIDES) for k in OF_SIDE},
    "friction": tuple(f"friction.{s}.{k}" for s in SIDES for k in ("coulomb", "viscous")),
    "stribeck": tuple(f"friction.{s}.{k}" for s in SIDES for k in ("static", "stribeck_speed")),
    "presliding": ("friction.stiffness", "friction.damping"), "stiffness": ("friction.stiffness",),
    "damping": ("friction.damping",), "delay": ("delay_s",),
}  # fmt: skip
"""Names for several keys at once, or shorter ones."""
USUAL = ("mass", "offset", *SHORT["friction"])


@dataclass(frozen=True)
class Belief:
    """Values by key, SI; ``noise`` of the sensor and ``force_noise``, what a model leaves of the force, both rms."""

    values: dict[str, float]
    noise: float
    period: float
    symmetric: bool = True
    force_noise: float = 0.0
    unit: str = "m"
    force_unit: str = "N"
    wanted: tuple[str, ...] = USUAL
    known: dict[str, float] = field(default_factory=dict)
    """Standard deviations that an earlier log gave, by key, of what was identifiable from it."""
    drive_unit: str = ""
    """Of the drive in that log."""

    def of(self, key: str, default: float = 0.0) -> float:
        """The value of a key."""
        return self.values.get(key, default)

    def side(self, name: str, forward: bool) -> float:
        """A friction value of a direction."""
        return self.of(f"friction.{'forward' if forward else 'backward'}.{name}")


def keys_of(names: Sequence[str]) -> tuple[str, ...]:
    """Keys of names or short names, each once.

    Raises:
        NameUnknown: no such key; names the nearest.
    """
    found: list[str] = []
    for name in names:
        if name not in KEYS and name not in SHORT:
            raise NameUnknown(f"there is no parameter {name!r}{nearest(name, [*SHORT, *KEYS])}")
        found += [k for k in SHORT.get(name, (name,)) if k not in found]
    return tuple(found)


def values_of(given: Mapping[str, float]) -> dict[str, float]:
    """Values by key; a short name sets both directions."""
    return {key: float(value) for name, value in given.items() for key in keys_of([name])}


def checked(belief: Belief) -> Belief:
    """The belief, where a test can be designed with it.

    Raises:
        ValueRefused: no mass, no noise, or a value out of its range.
    """
    for key, value in belief.values.items():
        positive = key != "offset"
        if not math.isfinite(value) or (positive and value < 0.0):
            allowed = "[0, inf)" if positive else "any finite number"
            raise ValueRefused(f"{key} = {value!r}: allowed range is {allowed}; overrule it with --guess {key}=VALUE")
    if not belief.of("mass") > 0.0:
        raise ValueRefused("the mass is not known: a guess within a factor of two serves, as in --guess mass=100")
    if not belief.noise > 0.0:
        raise ValueRefused("the sensor's noise is not known: give --encoder-step, or --noise")
    if not 0.0 < belief.period < 1.0:
        raise ValueRefused(f"period = {belief.period!r} s: allowed range is (0, 1)")
    needs = {"coulomb": "friction", "static": "stribeck", "stribeck_speed": "stribeck"}
    pairs = {k.replace("static", "stribeck_speed") for k in belief.wanted if k.endswith("static")}
    bristles = {"friction.stiffness"} if "friction.damping" in belief.wanted else set()
    for key in (*belief.wanted, *sorted(pairs | bristles)):
        name = key.rsplit(".", 1)[-1]
        if (name in needs or key in ("friction.stiffness", "backlash")) and not belief.of(key) > 0.0:
            short = name if name in SHORT else key
            raise ValueRefused(f"{key} is wanted, and a test for it needs a guess of it: --guess {short}=VALUE")
    if any(k in belief.wanted for k in SHORT["presliding"]) and not level(belief) > 0.0:
        raise ValueRefused(
            "Coulomb friction is 0, and a test for pre-sliding must stay below it: --guess coulomb=VALUE"
        )
    return belief


def level(belief: Belief) -> float:
    """Force up to which the axis stays at rest in both directions, N or N m; 0 where neither has friction."""
    sides = [max(belief.side("static", ahead), belief.side("coulomb", ahead)) for ahead in (True, False)]
    return min((side for side in sides if side > 0.0), default=0.0)


def belief_of(
    path: str | Path, wanted: Sequence[str] | None = None, guess: Mapping[str, float] | None = None
) -> tuple[Belief, Limits]:
    """What a machine file (``.toml``) or a fit of ``identify axis --json`` says, and the limits that its log kept.

    Values, noise, and what is missing: ``wanted`` where nothing else is asked for; ``guess`` overrules values.

    Raises:
        DataError: no such file, no machine file, no JSON, or no fit of an axis.
        ValueRefused: nothing is missing and nothing asked for.
    """
    if Path(path).suffix.casefold() == ".toml":
        belief, limits = of_machine(path)
        belief = replace(belief, values={**belief.values, **values_of(guess or {})})
    else:
        belief, limits = _of_fit(path, guess or {})
    names = keys_of(wanted) if wanted is not None else belief.wanted
    if not names:
        raise ValueRefused(f"{path}: nothing is missing; say what is to be determined better, as in --tell friction")
    return guessed(replace(belief, wanted=names), limits.speed), limits


def _of_fit(path: str | Path, guess: Mapping[str, float]) -> tuple[Belief, Limits]:
    seen = _read(Path(path))
    try:
        parameters = {k: p for k, p in seen["parameters"].items() if k in KEYS}
        values = {k: float(p["value"]) for k, p in parameters.items() if p["value"] is not None}
        # Version 0.1.0 wrote "told" for "identifiable".
        known = {k: (p["high"] - p["low"]) / (2.0 * quantile()) for k, p in parameters.items()
                 if p.get("how") == "fitted" and p.get("identifiable", p.get("told"))
                 and None not in (p["low"], p["high"])}  # fmt: skip
        low, high = map(float, seen["travel"])
        limits = Limits(low, high, float(seen["top_speed"]), float(seen["top_acceleration"]))
        missing = tuple(k for k in seen["missing"] if k in KEYS)
        step = float(seen["encoder_step"])
        belief = Belief(
            {**values, **values_of(guess)}, max(float(seen["noise"] or 0.0), step / math.sqrt(12.0)),
            float(seen["period_s"]), bool(seen["symmetric"]), _force_noise(seen), str(seen["position_unit"]),
            _force_unit(seen), missing, known, str(seen.get("drive_unit") or ""),
        )  # fmt: skip
    except (KeyError, TypeError, ValueError, AttributeError) as problem:
        raise DataError(
            f"{path}: is no fit of an axis ({problem}); expected a machine file, or what leadscrew identify axis LOG "
            "--json printed"
        ) from None
    return belief, limits


def guessed(belief: Belief, top_speed: float) -> Belief:
    """Starting values of what is wanted and not known at all, from Coulomb friction, top speed and noise.

    Stribeck speed: 2 % of the top speed; static: 1.3 times Coulomb friction; pre-sliding: 30 times the noise, 10 um at
    least; damping: what makes it decay in 1 ms; backlash: 30 times the noise, 10 um at least.
    """
    found, small = dict(belief.values), max(30.0 * belief.noise, 1e-5)
    stribeck = any(k.endswith(("static", "stribeck_speed")) for k in belief.wanted)
    for side in SIDES if stribeck else ():
        coulomb = found.get(f"friction.{side}.coulomb", 0.0)
        if not found.get(f"friction.{side}.stribeck_speed"):
            found[f"friction.{side}.stribeck_speed"] = 0.02 * top_speed
        if found.get(f"friction.{side}.static", 0.0) <= coulomb:
            found[f"friction.{side}.static"] = 1.3 * coulomb
    if any(k in belief.wanted for k in SHORT["presliding"]):
        found["friction.stiffness"] = (
            found.get("friction.stiffness") or found.get("friction.forward.coulomb", 0.0) / small
        )
        found["friction.damping"] = found.get("friction.damping") or 1e-3 * found["friction.stiffness"]
    if "backlash" in belief.wanted:
        found["backlash"] = found.get("backlash") or small
    return replace(belief, values=found)


def _force_noise(seen: Mapping[str, Any]) -> float:
    judged = seen.get("judged") or []
    return float(judged[0].get("rms_force") or 0.0) if judged else 0.0


def _force_unit(seen: Mapping[str, Any]) -> str:
    mass = seen["parameters"].get("friction.forward.coulomb", {})
    return str(mass.get("unit") or seen.get("drive_unit") or "N")


def _read(path: Path) -> dict[str, Any]:
    seen = reading.json_object(path)
    # What a command printed may hold the fit one level down.
    return seen["fit"] if isinstance(seen.get("fit"), dict) else seen


def of_machine(path: str | Path) -> tuple[Belief, Limits]:
    """The belief, its ``wanted`` being what is not identifiable from the log of the machine, and the log's limits.

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
        bool(symmetric), _machine_force_noise(machine), "rad" if rotary else "m",
        _machine_force_unit(machine, rotary), _missing(machine, values, bool(symmetric), limits.speed),
        _known(machine, limits.speed), machine.drive_unit,
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


def _machine_force_unit(machine: MachineFile, rotary: bool) -> str:
    """Where no force of the drive was told, its own unit stands for it."""
    known = machine.drive_unit in ("N", "N m") or machine.parameters.get("force_per_drive", 1.0) != 1.0
    return ("N m" if rotary else "N") if known else machine.drive_unit


def _machine_force_noise(machine: MachineFile) -> float:
    """What the model left of the force on the log that it was fitted to; 0 where the file does not say."""
    training = machine.identified.get("training", {})
    found = training.get("rms_force", 0.0) if isinstance(training, dict) else 0.0
    return float(found) if isinstance(found, int | float) and found > 0.0 else 0.0


def _missing(machine: MachineFile, values: dict[str, float], symmetric: bool, speed: float) -> tuple[str, ...]:
    """Keys that its log fixed or that are not identifiable, in the order of :data:`KEYS`; not those that no motion
    determines.
    """
    from leadscrew.toml_file import flat

    fixed = machine.identified.get("fixed", {})
    reasons = dict(flat(fixed)) if isinstance(fixed, dict) else {}
    beyond = {"backlash"} | (set() if symmetric else {"offset"})
    wide = {k for k in machine.intervals if not _identifiable(machine, k, speed)}
    open_to = ({k for k, why in reasons.items() if why != "given"} | wide) - beyond
    return tuple(k for k in KEYS if k in open_to and (k in values or k.startswith("friction.")))


def _known(machine: MachineFile, speed: float) -> dict[str, float]:
    """Standard deviations of what was identifiable from its log."""
    return {k: (high - low) / (2.0 * quantile()) for k, (low, high) in machine.intervals.items()
            if k in KEYS and high > low and _identifiable(machine, k, speed)}  # fmt: skip


def _identifiable(machine: MachineFile, key: str, speed: float) -> bool:
    """By the rule of :mod:`leadscrew.identify.estimation`, the force of sliding at ``speed`` being that of the log."""
    low, high = machine.intervals[key]
    half, value = 0.5 * (high - low), float(machine.parameters.get(key, machine.delay_s if key == "delay_s" else 0.0))
    name, negligible = key.rsplit(".", 1)[-1], 0.0
    if key == "delay_s":
        negligible = machine.period
    elif name == "static":
        value -= float(machine.parameters.get(key.replace(".static", ".coulomb"), 0.0))
    elif name in ("offset", "coulomb", "viscous"):
        sliding = max(
            float(machine.parameters.get(f"friction.{s}.coulomb", 0.0))
            + speed * float(machine.parameters.get(f"friction.{s}.viscous", 0.0))
            for s in SIDES
        )
        negligible = LITTLE * sliding / (speed if name == "viscous" else 1.0)
    return identifiable(value, half, negligible)
