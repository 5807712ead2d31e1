"""Self-organising fuzzy neural network (SOFNN) of a tangential knife: 49 rules, corrected as it cuts.

Every sample ``k``, with the firing strengths ``h`` of the rules, of which four are not 0:

    E, EC, g(k)                                                deviation, its change, correction: levels
    target = D(k - m_c) + g(k)                                 stored: equation (3) as it is printed
    target = h(k - m_c) . w + g(k)                             accumulate
    J = (target - h(k - m_c) . w)^2 / 2                        while J >= tolerance, at most ``passes`` times:
    w += P h (target - h . w) / s,    s = h' P h + r           h of the sample k - m_c
    P += q I - P h h' P / s
    D(k) = clip(h(k) . w, -6, 6),   d(k) = clip(k_d D(k), -most, most)        after the learning

with the diagonal of ``P`` capped and the consequents clamped: :mod:`leadscrew.neural.kalman`. Without forgetting, which
makes ``P`` grow without end where nothing excites it. ``learner = "nlms"`` is the cheap alternative, normalised LMS on
the four rules: ``w += mu h (target - h . w) / (h . h)``.

**Stored or accumulate.** The stored form is ``d(k) = d(k - m_c) + g``: a comb of integrators, slow, and at a low gain
indifferent to the true delay. The other form adds ``g`` every sample; it is faster and needs about the right delay, as
a PID does.

**When not to use it**: tuned as carefully, the stored form with three gains in place of the rules does as well, a PID
nearly, feed-forward of the curvature better. Rules over (e, ec)
are an integrator, not a memory: frozen, they keep about a third of what learning gave.

When nothing is learned: :mod:`leadscrew.controllers._sofnn.organising`. Bumpless start: the rules that fire are
shifted so that the next output is the last one; what was learned before is lost. Where the cut is not seen at the
start nothing is known of which rules fire: none is shifted, the offset fades from the last output, and from there to
the rules' one when the cut is seen (:mod:`leadscrew.controllers._sofnn.levels`). Learned rules are given to a new start
by :func:`~leadscrew.controllers.with_rules`.

Source: the seven steps of the paper of the study ``sofnn_tangent`` (Deng, Liu, Wu, Zhang); where it is silent, a
reconstruction. With ``K_p*`` of its step (4) the paper means ``k_d``.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, NamedTuple, cast

import numpy as np

from leadscrew.controllers._sofnn.fixed import Rules
from leadscrew.controllers._sofnn.levels import (
    KD,
    KE,
    KEC,
    ROOM,
    Aligned,
    FadeS,
    FilterS,
    Most,
    PerSecond,
    Scales,
    Short,
    Watch,
    held,
    lacking,
    scales,
    sent,
    taken_over,
    watched,
)
from leadscrew.controllers._sofnn.organising import (
    NOTHING,
    At,
    Clamp,
    DeadZone,
    Delay,
    Freeze,
    Kg,
    Leak,
    Learning,
    Measure,
    PastD,
    PastE,
    PastEC,
    Source,
    Table,
    Target,
    Weights,
    leak,
    learns,
    measure,
    place_after,
    place_before,
    rectified,
)
from leadscrew.controllers._sofnn.rules import shifted
from leadscrew.fuzzy.inference import Axis
from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Lt, Unit
from leadscrew.neural.inference_net import AXIS, W0, fired, network_output
from leadscrew.neural.kalman import kalman_learn
from leadscrew.neural.performance import GOLDEN, TABLE, Performance

UNSURE = np.eye(49)
"""Covariance after a bumpless start."""


class SofnnParams(NamedTuple):
    """Scales, correction, learning, safeguards."""

    k_e: KE = 6.0 / 90.0
    k_ec: KEC = 6.0 / 90.0
    per_second: PerSecond = False
    k_d: KD = 2.5
    filter_s: FilterS = 0.05
    most: Most = 15.0
    fade_s: FadeS = 0.2
    kg: Kg = 1.0
    source: Source = 0
    table: Table = TABLE
    net: Performance = GOLDEN
    target: Target = 0
    delay: Delay = 6
    learner: Annotated[Literal["kalman", "nlms"] | int, Doc("Kalman filter, or normalised LMS on the four rules")] = 0
    r: Annotated[float, Ge(1e-9), Le(1e6), Doc("variance of a target, levels squared, R")] = 0.01
    q: Annotated[float, Ge(0), Le(1e3), Doc("random walk of a consequent, levels squared a sample, Q")] = 0.05
    cap: Annotated[float, Gt(0), Le(1e6), Doc("largest variance of a consequent, levels squared")] = 4.0
    mu: Annotated[float, Ge(0), Lt(2), Doc("step of the normalised LMS")] = 0.8
    passes: Annotated[int, Ge(1), Le(5), Doc("updates a sample, at most; the inner loop of step (7)")] = 1
    tolerance: Annotated[float, Ge(0), Le(1e3), Doc("J below which no update is made, levels squared")] = 0.0
    dead_zone: DeadZone = 0.0
    leak: Leak = 0.001
    clamp: Clamp = 6.0
    prior: Rules = W0
    learning: Learning = True
    freeze: Freeze = True


class Learner(NamedTuple):
    """How the rules are changed, as the step reads it."""

    target: int
    learner: int
    r: float
    q: float
    cap: float
    mu: float
    passes: int
    tolerance: float


class SofnnPlan(NamedTuple):
    """The parameters as the step reads them."""

    scales: Scales
    axis: Axis
    measure: Measure
    learner: Learner
    prior: np.ndarray


class SofnnState(NamedTuple):
    """What is known of the deviation, the rules and how sure they are, what fired."""

    watch: Watch = Watch()
    weights: Weights = W0
    covariance: Annotated[np.ndarray, Doc("of the consequents, 49 x 49, levels squared, P")] = np.eye(49)
    past_e: PastE = np.zeros(ROOM)
    past_ec: PastEC = np.zeros(ROOM)
    past_d: PastD = np.zeros(ROOM)
    at: At = 0
    updates: Annotated[int, Doc("updates in the last sample")] = 0
    offset: Annotated[float, Unit("deg"), Doc("offset sent, d")] = 0.0
    aligned: Aligned = 0
    short: Short = 0.0


def ready(params: SofnnParams, dt: float) -> SofnnPlan:
    """The parameters as the step reads them."""
    learner = Learner(
        int(params.target),
        int(params.learner),
        params.r,
        params.q,
        params.cap,
        params.mu,
        params.passes,
        params.tolerance,
    )
    return SofnnPlan(scales(params, dt), AXIS, measure(params), learner, np.array(params.prior, dtype=float))


def nlms(weights, past, innovation, mu, clamp):
    """Normalised LMS on the four rules, in place; gives the sum of the squared firing strengths."""
    k = 7 * past.j + past.i
    h0 = (1.0 - past.nu) * (1.0 - past.mu)
    h1 = (1.0 - past.nu) * past.mu
    h2 = past.nu * (1.0 - past.mu)
    h3 = past.nu * past.mu
    square = h0 * h0 + h1 * h1 + (h2 * h2 + h3 * h3)
    step = mu * innovation / square
    weights[k] = held(weights[k] + h0 * step, clamp)
    weights[k + 1] = held(weights[k + 1] + h1 * step, clamp)
    weights[k + 7] = held(weights[k + 7] + h2 * step, clamp)
    weights[k + 8] = held(weights[k + 8] + h3 * step, clamp)
    return square


def learn(p, clamp, weights, covariance, past, stored, g):
    """Step (6) and the loop of step (7), in place; gives the number of updates."""
    target = (stored if p.target == 0 else network_output(weights, past)) + g
    updates = 0
    for _ in range(p.passes):
        innovation = target - network_output(weights, past)
        if 0.5 * innovation * innovation >= p.tolerance:
            if p.learner == 0:
                kalman_learn(weights, covariance, past, innovation, p.r, p.q, p.cap, clamp)
            else:
                nlms(weights, past, innovation, p.mu, clamp)
            updates = updates + 1
    return updates


def align(params, command, feedback, output):
    """The state from which the next output is ``output``: the prior; a step that sees shifts the rules that fire."""
    watch = taken_over(command, feedback)
    return SofnnState(watch, params.prior, UNSURE, NOTHING, NOTHING, NOTHING, 0, 0, output, 1, 0.0)


@controller(SofnnParams, SofnnState, prepare=ready, align=align, unit="deg", drive="position")
def sofnn(p, s, command, feedback, dt):
    """Self-organising fuzzy neural network: 49 rules corrected by a Kalman filter as it cuts; an offset angle."""
    watch = watched(p.scales, s.watch, command, feedback)
    e = p.scales.k_e * watch.error
    ec = p.scales.k_ec * watch.rate
    g = rectified(p.measure, watch.error, e, ec)
    if s.aligned == 1 and watch.blind == 0:
        shifted(s.weights, fired(p.axis, p.axis, e, ec), held(s.offset / p.scales.k_d, 6.0), p.measure.clamp)
    updates = 0
    if learns(p.measure, p.scales.most, watch.known, s.offset, g):
        then = place_before(s.at, p.measure.delay)
        past = fired(p.axis, p.axis, s.past_e[then], s.past_ec[then])
        updates = learn(p.learner, p.measure.clamp, s.weights, s.covariance, past, s.past_d[then], g)
        if p.measure.leak > 0.0:
            leak(s.weights, p.prior, p.measure.leak)
    level = held(network_output(s.weights, fired(p.axis, p.axis, e, ec)), 6.0)
    short = lacking(p.scales, s.watch.blind, s.aligned, s.short, level, s.offset)
    offset = sent(p.scales, watch, level, short, s.offset)
    s.past_e[s.at] = e
    s.past_ec[s.at] = ec
    s.past_d[s.at] = level
    at = place_after(s.at)
    return SofnnState(
        watch, s.weights, s.covariance, s.past_e, s.past_ec, s.past_d, at, updates, offset, 0, short
    ), offset


cast(Any, sofnn.step).takes_cut_line = True
