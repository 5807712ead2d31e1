"""Rows of single functions in a compiled loop: what a loop costs with it less what it costs without."""

from __future__ import annotations

import ctypes
from functools import partial
from typing import Any

import numpy as np

from leadscrew.bench import measuring, probes
from leadscrew.bench.measuring import interleaved, row
from leadscrew.bench.yardstick import NoCompilerError, build

POINTS = 20_000


def inference_rows(rounds: int) -> list[dict[str, Any]]:
    """36 rules in the loop, at 20,000 points that fill the square."""
    blocks = {**probes.INFERENCES, "without": probes.adds}
    seen = interleaved({k: measuring.single(probes.probe(b), POINTS) for k, b in blocks.items()}, rounds)
    ns = {k: (v - seen["without"]) / POINTS * 1e9 for k, v in seen.items()}
    bounds = {"throughput": 15.0}
    return [
        row("36-rule inference", f"{k}, marginal cost in the loop", ns[k], "ns", at_most=bounds.get(k))
        for k in probes.INFERENCES
    ]


def libm(rounds: int) -> dict[str, float]:
    """Nanoseconds a call of the C library's functions, empty without a compiler."""
    try:
        library = build()
    except NoCompilerError:
        return {}
    x, out = np.linspace(-0.9, 0.9, POINTS), np.zeros(POINTS)
    arguments = {"pow": x + 1.5, "exp": x * 3.0, "sin": x * 3.0}
    pointers = {k: v.ctypes.data_as(ctypes.c_void_p) for k, v in arguments.items()}
    to = out.ctypes.data_as(ctypes.c_void_p)
    n = ctypes.c_long(POINTS)
    calls = {k: partial(getattr(library, f"{k}_libm_points"), pointers[k], to, n) for k in arguments}
    return {k: v / POINTS * 1e9 for k, v in interleaved(calls, rounds).items()}


def function_rows(rounds: int) -> list[dict[str, Any]]:
    """Portable functions, one run and in lanes, against the C library."""
    blocks = {**probes.FUNCTIONS, "without": probes.nothing}
    made = {k: probes.probe(b) for k, b in blocks.items()}
    runs, theirs = 64, libm(rounds)
    once = interleaved({k: measuring.single(loop, POINTS) for k, loop in made.items()}, rounds)
    varied = {"controller.sum": np.linspace(0.8, 1.0, runs)}
    lanes = interleaved({k: measuring.batch(loop, 2000, varied) for k, loop in made.items()}, rounds)
    rows = []
    for k in probes.FUNCTIONS:
        scalar = (once[k] - once["without"]) / POINTS * 1e9
        lane = (lanes[k] - lanes["without"]) / (2000 * runs) * 1e9
        remark = f"libm {theirs[k]:.1f} ns" if k in theirs else ""
        rows.append(row(f"portable {k}", "one run, marginal cost in the loop", scalar, "ns", remark=remark))
        rows.append(row(f"portable {k}", "in lanes, marginal cost in the loop", lane, "ns", remark=remark))
    return rows
