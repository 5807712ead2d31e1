"""The fuzzy network of a tangential knife, 49 rules on the deviation of the cut and its change, and how it learns.

    E = k_e e,  EC = k_ec ec    D = sum a_k w_k,  a_k = mu_i(E) nu_j(EC)    d = clip(k_d D, -max_offset, max_offset)

Four rules fire at most and the ``a_k`` sum to one, so ``D`` is the bilinear interpolation of the 49 consequents ``w``
(levels, number ``7 j + i``): :mod:`leadscrew.neural.inference_net`. From reading to level and from level to offset:
:mod:`leadscrew.controllers._sofnn.levels`. Where the correction ``g`` comes from, which rules it refers to and when
nothing is learned: :mod:`leadscrew.controllers._sofnn.organising`.

**fnn, fixed.** The ``rules`` are those after Kalman training; the untrained ones
(:func:`~leadscrew.neural.inference_net.initial_rules`) make it a plain fuzzy controller. *What it can do*: the rules
are a map without memory, of slope about -1 at the origin, so of a slow deviation it takes away ``1 - 1 / (1 + g k_d
k_e)`` for a cut that turns ``g`` times the offset: 14 % at the paper's scales, g = 1.

**sofc, credit.** The standard self-organising fuzzy controller: a table corrects the rules directly.

    w_k += a_k(k - m_c) g(k)                                   the rules that fired m_c samples ago, each by its part
    w_k += a_k(k - m_c) (D(k - m_c) + g(k) - what they say now)      target = 0

Each of the at most four rules that caused what is seen now is credited with the correction in proportion to its part in
it. What was said then becomes ``g sum a_k^2`` more, between a quarter of ``g`` (between four rules) and all of it (on a
rule's peak). T. J. Procyk, E. H. Mamdani, *A linguistic self-organizing process controller*, Automatica 15, 1979, put
in the place of the rules that fired the one that should have fired (``target = 0``, equation (3) of the paper). Later
forms add the correction to what the rule says now (the default; J. Jantzen, *The self-organising fuzzy controller*,
Technical University of Denmark, 1998, to the one cell responsible). The paper does not spell the law out: the weighting
by firing strength is our choice. The rules at the start are the untrained ones, as there is no network to train.

**sofnn, Kalman filter or LMS.** Every sample ``k``, with the firing strengths ``h`` of the rules:

    target = D(k - m_c) + g(k)                                 stored: equation (3) as it is printed
    target = h(k - m_c) . w + g(k)                             accumulate
    J = (target - h(k - m_c) . w)^2 / 2                        while J >= tolerance, at most ``passes`` times:
    w += P h (target - h . w) / s,    s = h' P h + r           h of the sample k - m_c
    P += q I - P h h' P / s
    D(k) = clip(h(k) . w, -6, 6),   d(k) = clip(k_d D(k), -max_offset, max_offset)    after the learning

with the diagonal of ``P`` capped and the consequents clamped: :mod:`leadscrew.neural.kalman`. Without forgetting, which
makes ``P`` grow without end where nothing excites it. ``learner = "nlms"`` is the cheap alternative, normalised LMS on
the four rules: ``w += mu h (target - h . w) / (h . h)``. *Stored or accumulate*: the stored form is
``d(k) = d(k - m_c) + g``, a comb of integrators, slow, and at a low gain indifferent to the true delay. The other form
adds ``g`` every sample; it is faster and needs about the right delay, as a PID does. *When not to use it*: tuned as
carefully, the stored form with three gains in place of the rules does as well, a PID nearly, feed-forward of the
curvature better. Rules over (e, ec) are an integrator, not a memory: frozen, they keep about a third of what learning
gave.

**sofnn_all_weights, all three groups.** As the paper prints it: an option, not a default.

    a_k = c_k mu_i(E) nu_j(EC)        D = sum a_k w_k / sum a_k        x = (49 w, 49 c, 5 centres of E, 5 of EC)
    dD/dw_k = a_k / sum a,   dD/dc_k = a_k (w_k - D) / (c_k sum a),   dD/dcentre through mu and nu

``w`` are the consequents (``v_ok``), the centres are the membership parameters (``v_ji``), and ``c`` is what is left of
the weights between memberships and rules (``v_kj``): two of them enter a rule as factors, so that only their product,
one certainty a rule, can be identified from the output. A factor common to all ``c`` cancels in the normalisation. One
extended Kalman filter learns all of them (:mod:`leadscrew.neural.groups`). ``q_certainty`` and ``q_centre`` are the
walks of the two groups; 0 leaves a group as it is, and with both 0 the block is ``sofnn`` to the last digits. The
centres stay in order and ``gap`` apart, the outer ones fixed, so that the sets cover the universe whatever is learned;
certainties stay between 0.1 and 10. ``forgetting`` below 1 divides the covariance by it before each update, as
textbooks do: where nothing excites a rule its variance then grows without end, unless ``cap`` holds it. *When not to
use it*: it learns what the consequents learn already. With a small walk nothing is gained; with a large one the
memberships wander to where no one would call them small any more, and the rules lose their meaning.

**Bumpless start**: ``fnn`` goes on from the last output and fades from there to what the rules say, with ``fade_s``.
The others start from the prior, with even centres and certainties of one, and shift the rules that fire so that the
next output is the last one; what was learned before is lost. Where the cut is not seen at the start nothing is known of
which rules fire: none is shifted, and the offset fades as after a gap. Learned rules are given to a new start by
:func:`~leadscrew.controllers.with_rules`.

Source: the paper of the study ``sofnn_tangent`` (Deng, Liu, Wu, Zhang): equations (1) and (2), the groups of weights of
section 2, its seven steps; where it is silent, a reconstruction. With ``K_p*`` of its step (4) the paper means ``k_d``.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, NamedTuple, cast

import numpy as np

from leadscrew.controllers._sofnn.levels import (
    KD,
    KE,
    KEC,
    ROOM,
    Aligned,
    FadeS,
    FilterS,
    MaxOffset,
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
    Rules,
    Source,
    Table,
    Target,
    Weights,
    answered,
    leak,
    learns,
    measure,
    place_before,
    seen,
)
from leadscrew.controllers._sofnn.rules import shifted
from leadscrew.fuzzy.inference import Axis
from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Lt, Unit
from leadscrew.neural.groups import SIZE, learn_all, said_by, triangle_of
from leadscrew.neural.inference_net import AXIS, CENTRES, W0, fired, initial_rules, network_output, strengths
from leadscrew.neural.kalman import kalman_learn
from leadscrew.neural.performance import GOLDEN, TABLE, Performance

UNTRAINED = initial_rules().ravel()
"""The rules before training."""
UNSURE = np.eye(49)
"""Covariance of the consequents before learning."""
CERTAIN = np.ones(49)
"""The certainties before learning."""
ALL_UNSURE = triangle_of(np.diag(np.repeat([1.0, 0.0], [49, SIZE - 49])))
"""Covariance of all groups before learning: only the consequents are open, the others become so by their walks."""

Offset = Annotated[float, Unit("deg"), Doc("offset sent, d")]
TargetVariance = Annotated[float, Ge(1e-9), Le(1e6), Doc("variance of a target, levels squared, R")]
ConsequentWalk = Annotated[float, Ge(0), Le(1e3), Doc("random walk of a consequent, levels squared a sample, Q")]
Walk = Annotated[float, Ge(0), Le(10), Doc("random walk of a parameter of this group a sample; 0: not learned")]
Passes = Annotated[int, Ge(1), Le(5), Doc("updates a sample, at most; the inner loop of step (7)")]
Tolerance = Annotated[float, Ge(0), Le(1e3), Doc("J below which no update is made, levels squared")]


# ---- fixed
class FnnParams(NamedTuple):
    """Scales and rules."""

    k_e: KE = 6.0 / 90.0
    k_ec: KEC = 6.0 / 90.0
    per_second: PerSecond = False
    k_d: KD = 2.5
    filter_s: FilterS = 0.05
    max_offset: MaxOffset = 15.0
    fade_s: FadeS = 0.2
    rules: Rules = W0


class FnnPlan(NamedTuple):
    """The same as the step reads it."""

    scales: Scales
    axis: Axis
    rules: np.ndarray


class FnnState(NamedTuple):
    """What is known of the deviation, and the offset sent."""

    watch: Watch = Watch()
    offset: Offset = 0.0
    aligned: Aligned = 0
    short: Short = 0.0


def ready_fnn(params: FnnParams, dt: float) -> FnnPlan:
    """The parameters as the step reads them."""
    return FnnPlan(scales(params, dt), AXIS, np.array(params.rules, dtype=float))


def align_fnn(params, command, feedback, output):
    """The state from which the next output is ``output``."""
    return FnnState(taken_over(command, feedback), output, 1, 0.0)


@controller(FnnParams, FnnState, prepare=ready_fnn, align=align_fnn, unit="deg", drive="position")
def fnn(p, s, command, feedback, dt):
    """Fixed fuzzy network of 49 rules on the deviation of the cut and its change; an offset angle."""
    watch = watched(p.scales, s.watch, command, feedback)
    here = fired(p.axis, p.axis, p.scales.k_e * watch.error, p.scales.k_ec * watch.rate)
    level = held(network_output(p.rules, here), 6.0)
    short = lacking(p.scales, s.watch.blind, s.aligned, s.short, level, s.offset)
    offset = sent(p.scales, watch, level, short, s.offset)
    return FnnState(watch, offset, 0, short), offset


# ---- by credit
class SofcParams(NamedTuple):
    """Scales, correction, safeguards."""

    k_e: KE = 6.0 / 90.0
    k_ec: KEC = 6.0 / 90.0
    per_second: PerSecond = False
    k_d: KD = 2.5
    filter_s: FilterS = 0.05
    max_offset: MaxOffset = 15.0
    fade_s: FadeS = 0.2
    kg: Kg = 1.0
    source: Source = 0
    table: Table = TABLE
    net: Performance = GOLDEN
    target: Target = 1
    delay: Delay = 6
    dead_zone: DeadZone = 0.0
    leak: Leak = 0.001
    clamp: Clamp = 6.0
    prior: Rules = UNTRAINED
    learning: Learning = True
    freeze: Freeze = True


class SofcPlan(NamedTuple):
    """The parameters as the step reads them."""

    scales: Scales
    axis: Axis
    measure: Measure
    target: int
    prior: np.ndarray


class SofcState(NamedTuple):
    """What is known of the deviation, the rules, what fired."""

    watch: Watch = Watch()
    weights: Weights = UNTRAINED
    past_e: PastE = np.zeros(ROOM)
    past_ec: PastEC = np.zeros(ROOM)
    past_d: PastD = np.zeros(ROOM)
    at: At = 0
    offset: Offset = 0.0
    aligned: Aligned = 0
    short: Short = 0.0


def ready_sofc(params: SofcParams, dt: float) -> SofcPlan:
    """The parameters as the step reads them."""
    return SofcPlan(scales(params, dt), AXIS, measure(params), int(params.target), np.array(params.prior, dtype=float))


def credit(weights, past, g, clamp):
    """Corrects the four rules that fired, each by ``g`` times its firing strength, in place."""
    k = 7 * past.j + past.i
    h = strengths(past)
    weights[k] = held(weights[k] + h.h0 * g, clamp)
    weights[k + 1] = held(weights[k + 1] + h.h1 * g, clamp)
    weights[k + 7] = held(weights[k + 7] + h.h2 * g, clamp)
    weights[k + 8] = held(weights[k + 8] + h.h3 * g, clamp)
    return g


def align_sofc(params, command, feedback, output):
    """The state from which the next output is ``output``: the prior; a step that sees shifts the rules that fire."""
    watch = taken_over(command, feedback)
    return SofcState(watch, params.prior, NOTHING, NOTHING, NOTHING, 0, output, 1, 0.0)


@controller(SofcParams, SofcState, prepare=ready_sofc, align=align_sofc, unit="deg", drive="position")
def sofc(p, s, command, feedback, dt):
    """Standard self-organising fuzzy controller: a table corrects its 49 rules as it cuts; an offset angle."""
    now = seen(p, s, command, feedback)
    here = fired(p.axis, p.axis, now.e, now.ec)
    if s.aligned == 1 and now.watch.blind == 0:
        shifted(s.weights, here, held(s.offset / p.scales.k_d, 6.0), p.measure.clamp)
    if learns(p, s, now):
        then = place_before(s.at, p.measure.delay)
        past = fired(p.axis, p.axis, s.past_e[then], s.past_ec[then])
        owed = s.past_d[then] - network_output(s.weights, past) if p.target == 0 else 0.0
        credit(s.weights, past, owed + now.g, p.measure.clamp)
        leak(s.weights, p.prior, p.measure.leak)
    end = answered(p, s, now, held(network_output(s.weights, here), 6.0))
    return SofcState(
        now.watch, s.weights, s.past_e, s.past_ec, s.past_d, end.at, end.offset, 0, end.short
    ), end.offset  # fmt: skip


# ---- by a Kalman filter or LMS
class SofnnParams(NamedTuple):
    """Scales, correction, learning, safeguards."""

    k_e: KE = 6.0 / 90.0
    k_ec: KEC = 6.0 / 90.0
    per_second: PerSecond = False
    k_d: KD = 2.5
    filter_s: FilterS = 0.05
    max_offset: MaxOffset = 15.0
    fade_s: FadeS = 0.2
    kg: Kg = 1.0
    source: Source = 0
    table: Table = TABLE
    net: Performance = GOLDEN
    target: Target = 0
    delay: Delay = 6
    learner: Annotated[Literal["kalman", "nlms"] | int, Doc("Kalman filter, or normalised LMS on the four rules")] = 0
    r: TargetVariance = 0.01
    q: ConsequentWalk = 0.05
    cap: Annotated[float, Gt(0), Le(1e6), Doc("largest variance of a consequent, levels squared")] = 4.0
    mu: Annotated[float, Ge(0), Lt(2), Doc("step of the normalised LMS")] = 0.8
    passes: Passes = 1
    tolerance: Tolerance = 0.0
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
    covariance: Annotated[np.ndarray, Doc("of the consequents, 49 x 49, levels squared, P")] = UNSURE
    past_e: PastE = np.zeros(ROOM)
    past_ec: PastEC = np.zeros(ROOM)
    past_d: PastD = np.zeros(ROOM)
    at: At = 0
    updates: Annotated[int, Doc("updates in the last sample")] = 0
    offset: Offset = 0.0
    aligned: Aligned = 0
    short: Short = 0.0


def ready_sofnn(params: SofnnParams, dt: float) -> SofnnPlan:
    """The parameters as the step reads them."""
    learner = Learner(
        int(params.target), int(params.learner), params.r, params.q, params.cap, params.mu, params.passes,
        params.tolerance,
    )  # fmt: skip
    return SofnnPlan(scales(params, dt), AXIS, measure(params), learner, np.array(params.prior, dtype=float))


def nlms(weights, past, innovation, mu, clamp):
    """Normalised LMS on the four rules, in place; gives the sum of the squared firing strengths."""
    k = 7 * past.j + past.i
    h = strengths(past)
    square = h.h0 * h.h0 + h.h1 * h.h1 + (h.h2 * h.h2 + h.h3 * h.h3)
    step = mu * innovation / square
    weights[k] = held(weights[k] + h.h0 * step, clamp)
    weights[k + 1] = held(weights[k + 1] + h.h1 * step, clamp)
    weights[k + 7] = held(weights[k + 7] + h.h2 * step, clamp)
    weights[k + 8] = held(weights[k + 8] + h.h3 * step, clamp)
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


def align_sofnn(params, command, feedback, output):
    """The state from which the next output is ``output``: the prior; a step that sees shifts the rules that fire."""
    watch = taken_over(command, feedback)
    return SofnnState(watch, params.prior, UNSURE, NOTHING, NOTHING, NOTHING, 0, 0, output, 1, 0.0)


@controller(SofnnParams, SofnnState, prepare=ready_sofnn, align=align_sofnn, unit="deg", drive="position")
def sofnn(p, s, command, feedback, dt):
    """Self-organising fuzzy neural network: 49 rules corrected by a Kalman filter as it cuts; an offset angle."""
    now = seen(p, s, command, feedback)
    here = fired(p.axis, p.axis, now.e, now.ec)
    if s.aligned == 1 and now.watch.blind == 0:
        shifted(s.weights, here, held(s.offset / p.scales.k_d, 6.0), p.measure.clamp)
    updates = 0
    if learns(p, s, now):
        then = place_before(s.at, p.measure.delay)
        past = fired(p.axis, p.axis, s.past_e[then], s.past_ec[then])
        updates = learn(p.learner, p.measure.clamp, s.weights, s.covariance, past, s.past_d[then], now.g)
        leak(s.weights, p.prior, p.measure.leak)
    end = answered(p, s, now, held(network_output(s.weights, here), 6.0))
    return SofnnState(
        now.watch, s.weights, s.covariance, s.past_e, s.past_ec, s.past_d, end.at, updates, end.offset, 0, end.short
    ), end.offset


# ---- all groups of weights
class AllWeightsParams(NamedTuple):
    """As :class:`SofnnParams`, and the two further groups."""

    k_e: KE = 6.0 / 90.0
    k_ec: KEC = 6.0 / 90.0
    per_second: PerSecond = False
    k_d: KD = 2.5
    filter_s: FilterS = 0.05
    max_offset: MaxOffset = 15.0
    fade_s: FadeS = 0.2
    kg: Kg = 1.0
    source: Source = 0
    table: Table = TABLE
    net: Performance = GOLDEN
    target: Target = 0
    delay: Delay = 6
    r: TargetVariance = 0.01
    q: ConsequentWalk = 0.05
    cap: Annotated[float, Gt(0), Le(1e300), Doc("largest variance of a parameter")] = 4.0
    q_centre: Walk = 0.0
    q_certainty: Walk = 0.0
    gap: Annotated[float, Unit("1"), Gt(0), Le(2), Doc("least distance of two centres, levels")] = 0.4
    passes: Passes = 1
    tolerance: Tolerance = 0.0
    forgetting: Annotated[float, Ge(0.9), Le(1), Doc("the covariance is divided by it; below 1 it grows")] = 1.0
    dead_zone: DeadZone = 0.0
    leak: Leak = 0.001
    clamp: Clamp = 6.0
    prior: Rules = W0
    learning: Learning = True
    freeze: Freeze = True


class Filter(NamedTuple):
    """How the weights are changed, as the step reads it."""

    target: int
    r: float
    q: float
    q_certainty: float
    q_centre: float
    cap: float
    clamp: float
    gap: float
    passes: int
    tolerance: float
    forgetting: float


class AllWeightsPlan(NamedTuple):
    """The parameters as the step reads them."""

    scales: Scales
    measure: Measure
    filter: Filter
    prior: np.ndarray


class AllWeightsState(NamedTuple):
    """What is known of the deviation, all weights and how sure they are, what fired."""

    watch: Watch = Watch()
    weights: Weights = W0
    certainties: Annotated[np.ndarray, Doc("one a rule, c")] = CERTAIN
    centres_e: Annotated[np.ndarray, Doc("seven centres of E, levels")] = CENTRES
    centres_ec: Annotated[np.ndarray, Doc("seven centres of EC, levels")] = CENTRES
    covariance: Annotated[np.ndarray, Doc("of all 108 parameters, P; lower triangle")] = ALL_UNSURE
    past_e: PastE = np.zeros(ROOM)
    past_ec: PastEC = np.zeros(ROOM)
    past_d: PastD = np.zeros(ROOM)
    at: At = 0
    offset: Offset = 0.0
    aligned: Aligned = 0
    short: Short = 0.0


def ready_all_weights(params: AllWeightsParams, dt: float) -> AllWeightsPlan:
    """The parameters as the step reads them."""
    kalman = Filter(
        int(params.target), params.r, params.q, params.q_certainty, params.q_centre, params.cap, params.clamp,
        params.gap, params.passes, params.tolerance, params.forgetting,
    )  # fmt: skip
    return AllWeightsPlan(scales(params, dt), measure(params), kalman, np.array(params.prior, dtype=float))


def learn_groups(p, s, e, ec, stored, g):
    """Step (6) and the loop of step (7), in place; gives the number of updates."""
    past = said_by(s.weights, s.certainties, s.centres_e, s.centres_ec, e, ec)
    target = (stored if p.target == 0 else past.level) + g
    updates = 0
    for _ in range(p.passes):
        past = said_by(s.weights, s.certainties, s.centres_e, s.centres_ec, e, ec)
        innovation = target - past.level
        if 0.5 * innovation * innovation >= p.tolerance:
            learn_all(p, s.weights, s.certainties, s.centres_e, s.centres_ec, s.covariance, past, innovation)
            updates = updates + 1
    return updates


def align_all_weights(params, command, feedback, output):
    """The state from which the next output is ``output``: the prior; a step that sees shifts the rules that fire."""
    watch = taken_over(command, feedback)
    return AllWeightsState(
        watch, params.prior, CERTAIN, CENTRES, CENTRES, ALL_UNSURE, NOTHING, NOTHING, NOTHING, 0, output, 1, 0.0
    )  # fmt: skip


@controller(
    AllWeightsParams, AllWeightsState, prepare=ready_all_weights, align=align_all_weights, unit="deg", drive="position"
)
def sofnn_all_weights(p, s, command, feedback, dt):
    """Self-organising network that learns consequents, certainties and membership centres; an offset angle."""
    now = seen(p, s, command, feedback)
    if s.aligned == 1 and now.watch.blind == 0:
        here = said_by(s.weights, s.certainties, s.centres_e, s.centres_ec, now.e, now.ec).fired
        shifted(s.weights, here, held(s.offset / p.scales.k_d, 6.0), p.measure.clamp)
    if learns(p, s, now):
        then = place_before(s.at, p.measure.delay)
        learn_groups(p.filter, s, s.past_e[then], s.past_ec[then], s.past_d[then], now.g)
        leak(s.weights, p.prior, p.measure.leak)
    output = said_by(s.weights, s.certainties, s.centres_e, s.centres_ec, now.e, now.ec)
    end = answered(p, s, now, held(output.level, 6.0))
    return AllWeightsState(
        now.watch, s.weights, s.certainties, s.centres_e, s.centres_ec, s.covariance, s.past_e, s.past_ec, s.past_d,
        end.at, end.offset, 0, end.short,
    ), end.offset  # fmt: skip


for block in (fnn, sofc, sofnn, sofnn_all_weights):
    cast(Any, block.step).takes_cut_line = True
