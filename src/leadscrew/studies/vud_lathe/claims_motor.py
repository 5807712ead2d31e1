"""Claims about the motor's data: what the paper prints of J255LYX02 against its own equations (2) and (3)."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from leadscrew.plants import motor_data as motor
from leadscrew.report.claim import Basis, Claim, Group, Kind, Sense, Verdict


def claim(
    name: str, source: str, statement: str, measured: float | str, unit: str, sense: Sense = "=",
    target: float | str | None = None, tolerance: float = 0.0, reason: str = "", *,
    paper: float | str | None = None, verdict: Verdict = "cannot be checked", kind: Kind = "report",
    group: Group = "ours", basis: Basis = "reconstructed plant",
) -> Claim:  # fmt: skip
    """A claim that only reports unless told otherwise; a number that is not finite is none."""
    value = measured if isinstance(measured, str) else float(measured) if math.isfinite(measured) else None
    return Claim(
        f"vud_lathe.{name}", source, group, basis, statement, paper, value, unit, sense, target, tolerance, kind,
        verdict, reason,
    )  # fmt: skip


def motor_claims() -> Iterator[Claim]:
    """All of them; they need no run."""
    found = motor.derived()
    peak, lasting = motor.PEAK, motor.CONTINUOUS

    def agree(one: float, other: float) -> Verdict:
        return "reproduced" if abs(one - other) <= 0.01 * one else "not reproduced"

    data: dict[str, Any] = {"basis": "paper's data", "group": "as printed"}
    same = agree(peak.resistance_ohm, lasting.resistance_ohm)
    yield claim("motor_resistance", "section II", "resistance of the armature, by the peak data", peak.resistance_ohm,
                "ohm", "=", lasting.resistance_ohm, 1e-9,
                f"48 V / 7.5 A; the continuous data, 24 V / 3.75 A, give {lasting.resistance_ohm:.3g} ohm",
                paper="48 V, 7.5 A; 24 V, 3.75 A", verdict=same, kind="required", **data)  # fmt: skip
    same = agree(peak.torque_constant, lasting.torque_constant)
    yield claim("motor_torque_constant", "section II", "torque constant, by the peak data", peak.torque_constant,
                "N m/A", "=", 3.07, 0.005,
                f"23 N m / 7.5 A; the continuous data give {lasting.torque_constant:.4g} N m/A",
                paper="23 N m, 7.5 A; 11.5 N m, 3.75 A", verdict=same, kind="required", **data)  # fmt: skip
    share = motor.SPEED_GAIN.value / found.speed_constant
    yield claim("motor_speed_constant", "(3), section II", "speed a volt without load, 1/K_t of the motor's data",
                found.speed_constant, "rad/(s V)", "=", 0.326, 0.0005,
                f"the gain 0.26 of (3) is {share:.2f} of it: near only if it is meant in rad/s a volt, and then the "
                f"motor turns {100.0 * (1.0 - share):.0f} % slower than its data say",
                paper=motor.SPEED_GAIN.value, verdict=agree(found.speed_constant, motor.SPEED_GAIN.value),
                kind="required", **data)  # fmt: skip
    volts = (peak.voltage.value, lasting.voltage.value)
    yield claim("motor_supply", "(2), section II", "voltage at full duty, by the gain of (2)", motor.SUPPLY.value, "V",
                "=", None, 0.0, "neither the peak nor the continuous voltage of the motor",
                paper="48 V, 24 V", verdict="reproduced" if motor.SUPPLY.value in volts else "not reproduced",
                **data)  # fmt: skip
    yield claim("motor_stall_current", "(2), section II", "current of a held motor at full duty",
                found.stall_current_a, "A", "=", None, 0.0,
                f"30 V / {found.resistance_ohm:.3g} ohm, {found.stall_torque_nm:.1f} N m; the continuous 3.75 A are "
                f"reached at a duty of {found.held_duty:.2f}, the peak of 7.5 A never", **data)  # fmt: skip
    yield claim("motor_inductance", "(3), section II", "inductance that the lags of (3) ask for",
                1000.0 * found.inductance_h, "mH", "=", None, 0.0,
                f"and an inertia of {found.inertia_kg_m2:.4f} kg m^2, screw and slide included", **data)  # fmt: skip
