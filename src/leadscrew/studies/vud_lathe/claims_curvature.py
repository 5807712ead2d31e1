"""Claims about step 3 of the paper: what samples say of the curvatures (8) and (9)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from leadscrew.report.claim import Basis, Claim, Group, Kind, Verdict
from leadscrew.studies.vud_lathe import curvature_trials as trials
from leadscrew.studies.vud_lathe.claims_arithmetic import CURVATURES
from leadscrew.studies.vud_lathe.tables import Move

NAMES = ("ee", "cc")
PART = 0.05
"""Part of the paper's number within which an estimate counts as the same."""


def curvature_claims(found: Mapping[str, Move]) -> list[Claim]:
    """Of the digest's section 8: first the estimates on a law with known curvature, then on Table 1."""
    return [*_known(), *_steps(), *_table_1(found), *_linear(found)]


def _row(
    name: str, source: str, statement: str, paper: float | None, measured: float, target: float, tolerance: float,
    reason: str, kind: Kind, group: Group = "as printed", basis: Basis = "paper's data", unit: str = "1",
) -> Claim:  # fmt: skip
    verdict: Verdict = "cannot be checked"
    if paper is not None:
        verdict = "reproduced" if abs(measured - paper) <= PART * abs(paper) else "not reproduced"
    return Claim(f"vud_lathe.{name}", source, group, basis, statement, paper, float(measured), unit, "=", target,
                 tolerance, kind, verdict, reason)  # fmt: skip


def _known() -> list[Claim]:
    """Random points: the truth is 1.96 and 1.35."""
    rows = []
    samples = trials.scattered()
    seed = f"seed {trials.SEED}, {trials.POINTS} points"
    for noise, wanted in ((0.0, (1.96, 1.35)), (0.001, (1.97, 1.36)), (0.005, (1.93, 1.34))):
        values, condition = trials.polynomial(samples.noisy(noise), 5)
        key = f"{1000 * noise:g}"
        for n, value, target, true in zip(NAMES, values, wanted, trials.TRUE, strict=True):
            rows.append(
                _row(f"curvature_random_{n}_noise{key}", "step 3",
                     f"u_{n} of a known cubic, random points, noise {noise:g}, odd polynomial of degree 5", None, value,
                     target, 0.005, f"true {true:g}; condition number {condition:.2f}; {seed}",
                     "report" if noise else "required", "ours", "arithmetic")
            )  # fmt: skip
    for bandwidth, wanted in ((0.1, (1.79, 1.25)), (0.2, (1.46, 1.03)), (0.3, (1.21, 0.83))):
        values = trials.local(samples.noisy(0.001), bandwidth)
        for n, value, target, true in zip(NAMES, values, wanted, trials.TRUE, strict=True):
            rows.append(
                _row(f"curvature_local_{n}_h{round(100 * bandwidth):02d}", "step 3",
                     f"u_{n} of a known cubic, random points, noise 0.001, local quadratics, bandwidth {bandwidth:g}",
                     None, value, target, 0.05, f"true {true:g}: {100 * (1 - value / true):.0f} % too low; {seed}",
                     "report", "ours", "arithmetic")
            )  # fmt: skip
    return rows


def _steps() -> list[Claim]:
    """Four steps of a loop with the known cubic: curves in the plane, not a region."""
    rows = []
    samples = trials.stepped()
    reach = np.abs(samples.points).max(axis=0)
    values, condition = trials.polynomial(samples.noisy(0.001), 3)
    for n, value, target, true, far in zip(NAMES, values, (1.97, 1.345), trials.TRUE, reach, strict=True):
        rows.append(
            _row(f"curvature_steps_{n}", "step 3",
                 f"u_{n} of a known cubic, four steps, noise 0.001, odd polynomial of degree 3", None,
                 value, target, 0.02,
                 f"true {true * far:.2f} where the steps reach ({far:.2f} of the universe), "
                 f"{100 * abs(value / (true * far) - 1):.0f} % off; condition number {condition:.0f}; it comes near "
                 "because the law is in the class that is fitted",
                 "report", "ours", "reconstructed plant")
        )  # fmt: skip
    for bandwidth in (0.2, 0.5):
        values = trials.local(samples.noisy(0.001), bandwidth)
        for n, value, true, target in zip(NAMES, values, trials.TRUE, (3.5, 1.1), strict=True):
            rows.append(
                _row(f"curvature_steps_local_{n}_h{round(100 * bandwidth):02d}", "step 3",
                     f"u_{n} of a known cubic, four steps, noise 0.001, local quadratics, bandwidth {bandwidth:g}",
                     None,
                     value, target, 0.6, f"true {true:g} at most: a step response does not carry it",
                     "report", "ours", "reconstructed plant")
            )  # fmt: skip
    return rows


def _table_1(found: Mapping[str, Move]) -> list[Claim]:
    rows = []
    whole = trials.table_1(found)
    asked: list[tuple[str, str, tuple[float, float], float | None, tuple[float, float], float, Kind]] = []
    for bandwidth, wanted in ((0.2, (4.6, 4.2)), (0.3, (1.4, 1.75)), (0.5, (0.8, 1.05))):
        asked.append((f"local_h{round(100 * bandwidth):02d}", f"local quadratics, bandwidth {bandwidth:g}",
                      trials.local(whole, bandwidth), None, wanted, 0.05, "report"))  # fmt: skip
    fits = [(f"odd{d}", f"odd polynomial of degree {d}", trials.polynomial(whole, d), wanted, tolerance)
            for d, wanted, tolerance in ((3, (15.7, 15.3), 0.05), (5, (179.0, 213.0), 0.5))]  # fmt: skip
    for name, wanted in (("r=-190", (1.48, 0.32)), ("r=190", (1.66, 0.27))):
        key = f"quadratic_{name.replace('r=-', 'm').replace('r=', 'p')}"
        fit = trials.polynomial(trials.table_1(found, name), 2, odd=False)
        fits.append((key, f"quadratic through the move {name} alone", fit, wanted, 0.005))
    asked += [(key, text, *fit, wanted, tolerance, "required") for key, text, fit, wanted, tolerance in fits]
    for key, text, values, number, wanted, tolerance, kind in asked:
        why = "" if number is None else f"; condition number {number:.3g}"
        for n, value, target, paper in zip(NAMES, values, wanted, CURVATURES, strict=True):
            rows.append(
                _row(f"curvature_table1_{key}_{n}", "(8)" if n == "ee" else "(9)", f"u_{n} from Table 1, {text}", paper,
                     value, target, tolerance,
                     f"the method decides the number: Table 1 does not carry {paper:g}{why}", kind)
            )  # fmt: skip
    return rows


def _linear(found: Mapping[str, Move]) -> list[Claim]:
    """A linear law fitted to Table 1: e and ec are nearly one thing in a closed loop."""
    points, duty = trials.table_1(found)
    weights = np.linalg.lstsq(points, duty, rcond=None)[0]
    along = float(np.corrcoef(points.T)[0, 1])
    why = f"e and ec of a move go together (correlation {along:.2f}), so their weights cannot be told apart"
    return [
        _row("pd_fit_e", "Table 1", "weight of e in a linear law fitted to Table 1", None, weights[0], -0.79, 0.005,
             why,
             "required"),
        _row("pd_fit_ec", "Table 1", "weight of ec in a linear law fitted to Table 1", None, weights[1], 0.38, 0.005,
             f"damping would need a weight below 0; {why}", "required"),
    ]  # fmt: skip
