"""Claims about Figure 5: what a circuit of two differentiators reads where the paper reads u_ee and u_cc."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from leadscrew.controllers.vud import power_law
from leadscrew.report.claim import Basis, Claim, Group, Kind, Sense, Verdict
from leadscrew.studies.vud_lathe import differentiator as circuit
from leadscrew.studies.vud_lathe.claims_arithmetic import CURVATURES
from leadscrew.studies.vud_lathe.curvature_trials import SCALE_MM, TRUE, StepRun, step_run

MOVE = "step_m190"
ERRORS = (0.9, 0.5, 0.25)
"""Where along the smooth law's move the readings are compared."""
POWER_ERRORS = (0.5, 0.1, 0.05)
START_S = 0.1
"""The step itself is no path of e and ec: five lags of the axis later it is over."""
GAIN, EXPONENT = (float(getattr(power_law.params, name)) for name in ("gain", "exponent"))
COUNT_MM = 0.001
"""Of the old servo's encoder."""


def original_scope(loops: Any) -> circuit.Scope:
    """The circuit at the terminals of the original controller during Table 1's move of -190 mm."""
    return circuit.scope(*circuit.signals(loops.run("ours.original_fit", MOVE)))


def smooth_scope(run: StepRun, lag_s: float = circuit.LAG_S) -> circuit.Scope:
    """The circuit on the same move under the law whose curvatures are 1.96 and 1.35 at most."""
    return circuit.scope(run.time, run.e, run.ec, run.duty, lag_s)


def differentiator_claims(loops: Any) -> list[Claim]:
    """All of them."""
    smooth = step_run(-190.0)
    return [*_relation(smooth), *_smooth(smooth), *_original(original_scope(loops))]


def _row(
    name: str, statement: str, paper: float | None, measured: float, unit: str, sense: Sense, target: float | None,
    tolerance: float, reason: str, kind: Kind = "required", group: Group = "as printed",
    basis: Basis = "reconstructed plant",
) -> Claim:  # fmt: skip
    verdict: Verdict = "cannot be checked"
    if paper is not None:
        verdict = "reproduced" if abs(measured - paper) <= 0.05 * paper else "not reproduced"
    return Claim(
        f"vud_lathe.fig5_{name}", "Figure 5, (8), (9)", group, basis, statement, paper, float(measured), unit, sense,
        target, tolerance, kind, verdict, reason,
    )  # fmt: skip


def _relation(run: StepRun) -> list[Claim]:
    """The chain rule, and a law without curvature."""
    dt = circuit.PERIOD_S
    parts = circuit.terms(run.e, run.ec, circuit.CUBIC)
    whole = np.gradient(np.gradient(run.duty, dt), dt)
    later = slice(round(START_S / dt), -2)
    left = np.abs(whole - sum(parts.values()))[later].max() / np.abs(whole[later]).max()
    k = int(np.argmax(np.abs(run.e) <= 0.5))
    share = parts["u_ee e'^2"][k] / whole[k]
    straight = circuit.scope(run.time, run.e, run.ec, -GAIN * run.e)
    reading = straight.over_e[round(START_S / dt) :]
    return [
        _row("relation", "d2u/dt2 less u_ee e'^2 + 2 u_ec e'c' + u_cc c'^2 + u_e e'' + u_c c'', over its largest",
             None, left, "1", "<=", 1e-3, 0.0,
             "a cubic with known curvatures on a step of -190 mm, from 0.1 s on; what is left is that of central "
             "differences"),
        _row("share", "part of d2u/dt2 that comes from u_ee, at e = -0.5", None, share, "1", "<=", 1.0, 0.0,
             f"{100.0 * (1.0 - share):.0f} % of the signal that the circuit shows is not curvature over e", "report"),
        _row("straight_law", "what (d2u/dt2) / (d2e/dt2) reads of a straight law u = -0.929 e, whose u_ee is 0", None,
             float(reading[np.argmax(np.abs(reading - GAIN))]), "1", "=", GAIN, 1e-6,
             "the slope, not the curvature: three identical circuits pass on a constant factor"),
    ]  # fmt: skip


def _smooth(run: StepRun) -> list[Claim]:
    seen = smooth_scope(run)
    rows = []
    for error in ERRORS:
        k = seen.at(error)
        key = f"e{round(100 * error):02d}"
        for name, reading, true in (
            ("ee", seen.over_e[k], TRUE[0] * abs(run.e[k])),
            ("cc", seen.over_c[k], TRUE[1] * abs(run.ec[k])),
        ):
            away = 100.0 * abs(reading / true - 1.0)
            rows.append(
                _row(f"smooth_{name}_{key}", f"what the circuit reads for u_{name} of the cubic at e = -{error:g}",
                     None,
                     reading, "1", "=", true, 0.05, f"true {true:.2f}: {away:.0f} % off", "report")
            )  # fmt: skip
    inside = (np.abs(seen.e) < 0.95) & (np.abs(seen.e) > 0.05)
    largest = {lag: float(smooth_scope(run, lag).over_e[inside].max()) for lag in circuit.LAGS_S}
    said = ", ".join(f"{value:.0f} with {1000 * lag:g} ms" for lag, value in largest.items())
    rows.append(
        _row("smooth_largest", "largest reading for u_ee of the cubic along the move, whose true largest is 1.96",
             None, min(largest.values()), "1", ">=", 10.0 * TRUE[0], 0.0,
             "a pole where the axis turns from speeding up to slowing down; the lag of the stages decides the "
             f"number: {said}")
    )  # fmt: skip
    return rows


def _original(seen: circuit.Scope) -> list[Claim]:
    """Our stand-in for the old controller, whose curvature has no bound."""
    rows = []
    for error in POWER_ERRORS:
        k = seen.at(error)
        e = abs(float(seen.e[k]))
        reading, true = float(seen.over_e[k]), float(circuit.power_curvature(e, GAIN, EXPONENT))
        path = GAIN * abs(2.0 * EXPONENT - 1.0) * e ** (EXPONENT - 1.0)
        rows.append(
            _row(f"original_e{round(100 * error):02d}",
                 f"what the circuit reads for u_ee of our stand-in at e = -{error:g}",
                 None, reading, "1", "=", path, 0.15 * path,
                 f"u_ee is {true:.3g} there; on e' = -k |e|^p the quotient is c (2p - 1) |e|^(p-1) = {path:.3f}, "
                 "whatever the curvature", group="ours")
        )  # fmt: skip
    at_count = float(circuit.power_curvature(COUNT_MM / SCALE_MM, GAIN, EXPONENT))
    where = circuit.error_with_curvature(CURVATURES[0], GAIN, EXPONENT)
    half = seen.at(0.5)
    rows += [
        _row("original_sup", "largest |u_ee| of our stand-in down to one count of the encoder", CURVATURES[0],
             at_count, "1",
             ">=", 1e6, 0.0,
             f"|u_ee| grows as |e|^({EXPONENT - 2.0:.2f}) without a bound: a largest value exists only because the "
             "reading stops", "report", "ours"),
        _row("original_where", "|e| at which |u_ee| of our stand-in is 1.96", None, where, "1", "=", 0.205, 5e-4,
             f"{SCALE_MM * where:.0f} mm from the target; nearer, it is more", "required", "ours", "arithmetic"),
        _row("original_cc", "what the circuit reads for u_cc of our stand-in at e = -0.5, which is 0", None,
             float(seen.over_c[half]), "1", "=", 0.0, 0.0,
             "our stand-in does not look at ec; " + ("the circuit still reads a curvature" if not
             math.isclose(float(seen.over_c[half]), 0.0, abs_tol=1e-6) else "the circuit agrees"), "report", "ours"),
    ]  # fmt: skip
    return rows
