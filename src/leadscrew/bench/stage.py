"""Rows of the ball-screw stage: ways to step stiff friction through a hold of 250 us, speed and error side by side."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from leadscrew.bench import entries, stage_c, stage_peers
from leadscrew.bench.machine import load
from leadscrew.bench.row import row
from leadscrew.bench.stage_schemes import (
    NM,
    PERIOD_S,
    SMOOTH,
    TRUTH,
    Scheme,
    angles,
    benchmark,
    error_nm,
    every,
    rodas,
)
from leadscrew.bench.timing import interleaved, repeated
from leadscrew.bench.yardstick import NoCompilerError
from leadscrew.plants._ballscrew_stage import INERTIA

NAMES = {"sine_wide": "stage, 5 sin t", "sine_fast": "stage, sin 2 pi t"}
SPANS = {"sine_wide": 8000, "sine_fast": 4000}
"""Holds that are timed: 2 s with one reversal, 1 s with two. Errors are over the whole run."""
ACCURATE_NM = 0.5
"""The error asked for."""
OURS = (rodas(1e-3), rodas(1e-4), rodas(1e-6), every("fixed", 50.0), every("fixed", 10.0), every("rk4", 1.0))
BEST = rodas(1e-4)
"""What the others are compared with."""
BY_HAND = (
    ("euler", 2.0), ("euler", 0.5), ("rk4", 2.0), ("rk4", 1.0), ("split", 1.0), ("implicit", 1.0),
    ("exponential", 25.0), ("exponential", 12.5),
)  # fmt: skip
HOLDS = 1060
"""Holds of sin 2 pi t past its first reversal, at 1000, for tools that take seconds for them."""
TARGETS: dict[str, float] = {rodas(1e-3).name: 500.0, rodas(1e-4).name: 500.0}
"""How many times faster than real time a scheme has to be."""


def speeds(sine: str, rounds: int, schemes: Sequence[Scheme] = OURS) -> tuple[dict[str, float], str]:
    """Processor nanoseconds a hold, by name, and why the C is missing where it is."""
    holds = SPANS[sine]
    times = {s.name: 10 if s.options.get("method") == "rodas" else 1 for s in schemes}
    calls: dict[str, Callable[[], object]] = {
        s.name: repeated(entries.single(benchmark(sine, s), holds), times[s.name]) for s in schemes
    }
    why = ""
    try:
        c = stage_c.ByHand(sine)
        calls |= {f"C {form} {us}": partial(c.run, form, us, holds) for form, us in BY_HAND}
    except NoCompilerError as error:
        why = str(error)
    return {k: v / holds / times.get(k, 1) * 1e9 for k, v in interleaved(calls, rounds).items()}, why


def real_time(ns: float) -> float:
    """How many times faster than real time."""
    return PERIOD_S / ns * 1e9


def our_rows(sine: str, ns: dict[str, float], truth: np.ndarray) -> list[dict[str, Any]]:
    """Each of our schemes: times real time and error."""
    rows = []
    for scheme in OURS:
        error, name = error_nm(sine, scheme, truth), NAMES[sine]
        substeps = scheme.options.get("substeps", 1)
        each = f"{ns[scheme.name] / substeps:.0f} ns a {'step' if substeps > 1 else 'hold'}"
        rows.append(
            row(name, f"ours, {scheme.name}", real_time(ns[scheme.name]), "x real time",
                at_least=TARGETS.get(scheme.name), integrator=scheme.name, error=1e-6 * error, remark=each)
        )  # fmt: skip
        if scheme.name in TARGETS:
            rows.append(
                row(name, f"error of {scheme.name}", error, "nm", at_most=ACCURATE_NM, integrator=scheme.name,
                    error=1e-6 * error)
            )  # fmt: skip
    ratio = ns[every("rk4", 1.0).name] / ns[BEST.name]
    rows.append(
        row(NAMES[sine], f"{BEST.name} against our RK4, 1 us", ns[BEST.name], "ns/hold", ratio=ratio, at_least=20.0,
            integrator=BEST.name, error=1e-6 * error_nm(sine, BEST, truth))
    )  # fmt: skip
    return rows


def c_rows(sine: str, ns: dict[str, float], truth: np.ndarray, why: str) -> list[dict[str, Any]]:
    """C by hand; the ratio is C over our RODAS."""
    if why:
        return [row(NAMES[sine], "C by hand", unit="x real time", remark=f"left out: {why}")]
    rows, c = [], stage_c.ByHand(sine)
    for form, us in BY_HAND:
        each = ns[f"C {form} {us}"]
        error = float(NM * np.abs(c.run(form, us, len(truth)) - truth).max())
        what = f"{stage_c.FORMS[form]}, {us:g} us"
        remark = f"{each * us / PERIOD_S / 1e6:.0f} ns a step; ratio: C over our {BEST.name}"
        rows.append(
            row(NAMES[sine], f"C by hand, {what}", real_time(each), "x real time", ratio=each / ns[BEST.name],
                integrator=what, error=1e-6 * error if math.isfinite(error) else None, remark=remark)
        )  # fmt: skip
    return rows


def scipy_rows(rounds: int, quick: bool) -> list[dict[str, Any]]:
    """SciPy up to a reversal of sin 2 pi t and past it; the ratio is to the fastest of ours that errs no more."""
    sine, holds = "sine_fast", HOLDS
    seconds = holds * PERIOD_S
    truth = angles(sine, TRUTH, seconds)
    schemes = (*OURS[:3], rodas(1e-8))
    calls = {s.name: repeated(entries.single(benchmark(sine, s), holds), 20) for s in schemes}
    ns = {k: v / holds / 20 * 1e9 for k, v in interleaved(calls, rounds).items()}
    errors = {s.name: float(NM * np.abs(angles(sine, s, seconds) - truth).max()) for s in schemes}
    rows = []
    for method, tolerances in stage_peers.METHODS.items():
        for rtol in tolerances[:1] if quick else tolerances:
            done = stage_peers.scipy_run(sine, method, rtol, holds)
            each, error = done.seconds / holds * 1e9, float(NM * np.abs(done.angles - truth).max())
            ours = next((s.name for s in schemes if errors[s.name] <= error), None)
            against = f"against our {ours}, error {errors[ours]:.1e} nm" if ours else "none of ours errs as little"
            rows.append(
                row(f"SciPy {method}", f"{NAMES[sine]}, first {seconds:g} s, past a reversal", real_time(each),
                    "x real time", ratio=each / ns[ours] if ours else None,
                    at_least=100.0 if ours and method == "LSODA" else None,
                    integrator=f"{method}, rtol {rtol:.0e}, a call a hold", error=1e-6 * error, remark=against)
            )  # fmt: skip
    return rows


def batch_rows(quick: bool) -> list[dict[str, Any]]:
    """Many runs at once: friction steps a second, on one core and on all; 1e9 is asked for."""
    sine, cores, rows = "sine_fast", os.cpu_count() or 1, []
    varied = {"plant.inertia": np.linspace(2.12e-4, INERTIA, 256 if quick else 1024)}
    for scheme in (BEST, every("fixed", 50.0), every("rk4", 1.0)):
        loop, steps = benchmark(sine, scheme), scheme.options.get("substeps", 1)
        holds = 20 if steps > 100 else 800
        error = 1e-6 * error_nm(sine, scheme, angles(sine, TRUTH))
        done = steps * holds * len(varied["plant.inertia"])
        alone = interleaved({"": entries.batch(loop, holds, varied)}, 3)[""]
        both = interleaved({"": entries.batch(loop, holds, varied, threads=cores)}, 3, time.perf_counter)[""]
        what = "a hold counts as one step" if steps == 1 else f"{holds * PERIOD_S:g} s in steps of {scheme.name}"
        facts: dict[str, Any] = {"integrator": scheme.name, "error": error}
        rows.append(
            row("stage, batch", f"{scheme.name}, one core", done / alone, "steps/s",
                remark=f"{what}; {real_time(1e9 * alone / done * steps):,.0f} x real time", **facts)
        )  # fmt: skip
        rows.append(
            row("stage, batch", f"{scheme.name}, {cores} cores", done / both, "steps/s", at_least=1e9,
                remark=f"wall time, load {load() or 0.0:.2f}", **facts)
        )  # fmt: skip
    return rows


def rows(rounds: int, quick: bool = False) -> list[dict[str, Any]]:
    """All rows of this file."""
    made = []
    for sine in SMOOTH:
        ns, why = speeds(sine, min(rounds, 5))
        truth = angles(sine, TRUTH)
        made += our_rows(sine, ns, truth) + c_rows(sine, ns, truth, why)
    return made + scipy_rows(min(rounds, 5), quick) + batch_rows(quick)
