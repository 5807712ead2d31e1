"""Rows of self-organisation: what a step that learns costs in a compiled loop, beside dense matrices and C by hand."""

from __future__ import annotations

import contextlib
import ctypes
import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from leadscrew.bench import measuring, probes
from leadscrew.bench.measuring import interleaved, load, row
from leadscrew.bench.yardstick import NoCompilerError, build
from leadscrew.controllers._sofnn import fnn, sofc, sofnn
from leadscrew.kernel.block import Block, controller
from leadscrew.neural.inference_net import W0, fired
from leadscrew.neural.performance import TABLE
from leadscrew.references._cut_line import TangentCommand
from leadscrew.sensors._cut_camera import SeenCut

POINTS = 20_000
BOUND_NS = 1000.0
REACH_DEG = 80.0
"""The deviations that are shown go evenly up to this, so that all rules fire."""


def seen(command):
    """The deviation that is shown."""
    return SeenCut(REACH_DEG * command.x, 1.0)


@controller(sofnn.params, sofnn.state, prepare=sofnn.prepare)
def learns(p, s, command, dt):
    """The self-organising network at the point."""
    return sofnn(p, s, TangentCommand(), seen(command), dt)


def dense_update(weights, covariance, h, innovation, r, q, cap, clamp):
    """The Kalman update as it stands in a book, with all 49 firing strengths, in place."""
    gain = np.zeros(49)
    s = r
    for i in range(49):
        total = 0.0
        for j in range(49):
            total = total + covariance[i, j] * h[j]
        gain[i] = total
        s = s + h[i] * total
    for i in range(49):
        weights[i] = min(max(weights[i] + gain[i] * innovation / s, -clamp), clamp)
    for i in range(49):
        for j in range(49):
            covariance[i, j] = covariance[i, j] - gain[i] * gain[j] / s
    for i in range(49):
        covariance[i, i] = covariance[i, i] + q
    for i in range(49):
        if covariance[i, i] > cap:
            scale = math.sqrt(cap / covariance[i, i])
            for j in range(49):
                covariance[i, j] = covariance[i, j] * scale
            for j in range(49):
                covariance[j, i] = covariance[j, i] * scale
    return s


@controller(sofnn.params, sofnn.state, prepare=sofnn.prepare)
def learns_densely(p, s, command, dt):
    """The same with learning switched off, and in its place a dense update of the rules that fire."""
    after, offset = sofnn(p, s, TangentCommand(), seen(command), dt)
    q = p.learner
    here = fired(p.axis, p.axis, p.scales.k_e * after.watch.error, p.scales.k_ec * after.watch.rate)
    k = 7 * here.j + here.i
    h = np.zeros(49)
    h[k] = (1.0 - here.nu) * (1.0 - here.mu)
    h[k + 1] = (1.0 - here.nu) * here.mu
    h[k + 7] = here.nu * (1.0 - here.mu)
    h[k + 8] = here.nu * here.mu
    dense_update(s.weights, s.covariance, h, 0.1 * command.y, q.r, q.q, q.cap, p.measure.clamp)
    return after, offset


@controller(sofc.params, sofc.state, prepare=sofc.prepare)
def credits_rules(p, s, command, dt):
    """The standard self-organising controller at the point."""
    return sofc(p, s, TangentCommand(), seen(command), dt)


@controller(fnn.params, fnn.state, prepare=fnn.prepare)
def stays(p, s, command, dt):
    """The fixed network at the point."""
    return fnn(p, s, TangentCommand(), seen(command), dt)


KALMAN, DENSE, IDLE = "Kalman, four rules", "Kalman, dense 49 x 49", "no learning"
BLOCKS: dict[str, Block] = {
    KALMAN: learns,
    DENSE: learns_densely(learning=False),
    "normalised LMS": learns(learner="nlms"),
    "standard self-organising controller": credits_rules,
    IDLE: learns(learning=False),
    "fixed network": stays,
}


class ByHand(ctypes.Structure):
    """Mirrors ``Network`` of ``c/sofnn.c``."""

    _fields_ = (
        *((name, ctypes.c_double) for name in ("k_e", "k_ec", "k_d", "keep", "most", "kg", "r", "q", "cap", "leak",
                                               "clamp", "reach")),
        ("table", ctypes.c_double * 169), ("prior", ctypes.c_double * 49), ("delay", ctypes.c_long),
    )  # fmt: skip


def by_hand() -> Callable[[], float]:
    """A call of the loop in C, which gives the sum of the offsets.

    Raises:
        NoCompilerError: no gcc.
    """
    library, p = build("sofnn.c"), sofnn.params
    library.sofnn_learn.argtypes, library.sofnn_learn.restype = [ctypes.POINTER(ByHand), ctypes.c_long], ctypes.c_double
    made = ByHand(
        k_e=p.k_e, k_ec=p.k_ec, k_d=p.k_d, keep=math.exp(-0.001 / p.filter_s), most=p.max_offset, kg=p.kg, r=p.r, q=p.q,
        cap=p.cap, leak=p.leak, clamp=p.clamp, reach=REACH_DEG, delay=p.delay,
    )  # fmt: skip
    made.table[:], made.prior[:] = TABLE.ravel().tolist(), W0.tolist()
    return partial(library.sofnn_learn, made, POINTS)


def nanoseconds(rounds: int, names: tuple[str, ...] = tuple(BLOCKS)) -> dict[str, float | None]:
    """Marginal cost of a step in a compiled loop, ns: a loop with it less the loop without.

    A loop looks at the end of each period whether all numbers of its state are finite; with the covariance of 49 rules
    these are 2,600, and the look is most of what a step costs that does not learn. ``C`` is not there without gcc.
    """
    calls: dict[str, Callable[[], object]] = {"none": measuring.single(probes.probe(probes.adds), POINTS)}
    calls |= {name: measuring.single(probes.probe(BLOCKS[name]), POINTS) for name in names}
    with contextlib.suppress(NoCompilerError):
        calls["C"] = by_hand()
    seen_s = {k: v / POINTS * 1e9 for k, v in interleaved(calls, rounds).items()}
    return {k: seen_s[k] - seen_s["none"] if k in seen_s else None for k in (*names, "C")}


def rows(rounds: int) -> list[dict[str, Any]]:
    """All rows of this file; the step with the Kalman filter has the target."""
    busy = load()
    ns = nanoseconds(rounds)
    name, remark = "self-organising network", "" if busy is None else f"load average {busy:.2f}"
    found = [
        row(name, f"{k}, marginal cost of a step in the loop", ns[k], "ns",
            at_most=BOUND_NS if k == KALMAN else None, remark=remark)
        for k in BLOCKS
    ]  # fmt: skip
    ours, still, theirs = ns[KALMAN], ns[IDLE], ns["C"]
    if ours is not None and still is not None:
        found.append(row(name, "Kalman, four rules, the learning alone", ours - still, "ns", remark=remark))
    ratio = None if ours is None or theirs is None else theirs / ours
    why = "no gcc" if theirs is None else "ratio: theirs over ours; it does not look whether numbers are finite"
    return [*found, row(name, "C by hand, four rules", theirs, "ns", ratio=ratio, remark=why)]
