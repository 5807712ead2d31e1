"""Machine files from what was identified: of an axis with its friction, and of a linear model."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from leadscrew.logs.measure import beyond_step
from leadscrew.machine.file import MachineFile
from leadscrew.util.errors import ValueRefused, entry_point

if TYPE_CHECKING:
    from leadscrew.identify.axis.result import AxisFit

SHOWN = {"m": ("mm", 1e3), "rad": ("rad", 1.0)}
"""Unit that a machine shows its position in, and how many of them an m or a rad is."""
MODELS = {"coulomb": "servo_axis", "stribeck": "servo_axis", "lugre": "servo_axis_lugre"}


@entry_point
def from_axis(
    fit: AxisFit, name: str, cascade: dict[str, float] | None = None, log: dict[str, Any] | None = None
) -> MachineFile:
    """The machine of a fit; ``cascade``: gains ``kp`` (1/s) and ``kv`` (drive s/m) of the controller of the log;
    ``log``: how its command is read again, :func:`leadscrew.machine.scenarios.of_log`.

    Where the log does not tell static friction it is Coulomb friction: no stick-slip is invented.

    Raises:
        ValueRefused: a fit without a mass above 0.
    """
    unit, scale = SHOWN[fit.position_unit]
    values = dict(fit.values)
    delay = max(values.pop("delay_s", 0.0), 0.0)
    if not values.get("mass", 0.0) > 0.0:
        raise ValueRefused(f"{fit.source}: the log does not tell the mass, so there is no machine: give it, --given")
    values.setdefault("force_per_drive", 1.0)
    for side in ("forward", "backward"):
        values.setdefault(f"friction.{side}.static", values.get(f"friction.{side}.coulomb", 0.0))
        values.setdefault(f"friction.{side}.stribeck_speed", 1e-3)
    if fit.model == "lugre":
        values.pop("backlash", None)
    turned = values["force_per_drive"] < 0.0
    values["force_per_drive"] = abs(values["force_per_drive"])
    low, high = fit.travel
    record: dict[str, Any] = {
        "source": fit.source, "warning": "; ".join(fit.faults) or None,
        "model": fit.model, "symmetric": fit.symmetric, "method": fit.method,
        "drive_turned": turned or None, "seconds": max((j.end_s for j in fit.judged), default=10.0),
    }  # fmt: skip
    for judged in fit.judged:
        record[judged.what.replace(", ", "_").replace(" ", "_").replace("-", "_")] = {
            f"rms_{unit}": scale * judged.rms, "nrmse_percent": judged.nrmse_percent, "rms_force": judged.rms_force,
        }  # fmt: skip
    beyond = beyond_step(fit.noise, fit.encoder_step)
    if fit.encoder_step and not beyond:
        record["noise"] = f"none beyond the rounding to steps of {scale * fit.encoder_step:.6g} {unit}"
    record["fixed"] = {key: p.note or p.how for key, p in fit.parameters.items() if p.how != "fitted"}
    gains = {k: v for k, v in (cascade or {}).items() if k in ("kp", "kv", "ki")}
    gains |= {k: abs(gains[k]) / scale for k in ("kv", "ki") if k in gains}
    return MachineFile(
        name=name, model=MODELS[fit.model], position_unit=unit, drive_unit=fit.drive_unit, period=fit.period,
        drive=fit.top_drive, speed=scale * fit.top_speed, acceleration=scale * fit.top_acceleration,
        travel=(scale * low, scale * high), parameters=values, delay_s=delay,
        resolution=scale * fit.encoder_step, noise=scale * beyond,
        intervals={k: (p.low, p.high) for k, p in fit.parameters.items() if p.how == "fitted" and p.low <= p.high},
        cascade=gains, identified=record, log=log or {},
    )  # fmt: skip


@entry_point
def from_linear(record: dict[str, Any], name: str, limits: dict[str, Any], source: str) -> MachineFile:
    """The machine of a linear model: ``numerator``, ``denominator``, ``delay_s``, ``position_unit``, ``drive_unit``,
    ``period`` (and ``resolution``, ``noise``); ``limits``: ``drive``, ``speed``, ``acceleration``, ``travel``.
    """
    return MachineFile(
        name=name, model="linear", position_unit=record["position_unit"], drive_unit=record["drive_unit"],
        period=float(record["period"]), drive=float(limits["drive"]), speed=float(limits["speed"]),
        acceleration=float(limits["acceleration"]), travel=tuple(limits["travel"]), delay_s=float(record["delay_s"]),
        parameters={key: [float(v) for v in record[key]] for key in ("numerator", "denominator")},
        resolution=float(record.get("resolution", 0.0)), noise=float(record.get("noise", 0.0)),
        identified={"source": source},
    )  # fmt: skip
