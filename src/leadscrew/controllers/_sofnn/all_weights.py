"""Self-organising network in which all three groups of weights learn, as the paper prints it: an option, not a default.

    a_k = c_k mu_i(E) nu_j(EC)        D = sum a_k w_k / sum a_k        x = (49 w, 49 c, 5 centres of E, 5 of EC)

``w`` are the consequents (``v_ok``), the centres are the membership parameters (``v_ji``), and ``c`` is what is left of
the weights between memberships and rules (``v_kj``): two of them enter a rule as factors, so that only their product,
one certainty a rule, can be told from the output. A factor common to all ``c`` cancels in the normalisation.

One extended Kalman filter learns all of them, with the derivatives

    dD/dw_k = a_k / sum a,   dD/dc_k = a_k (w_k - D) / (c_k sum a),   dD/dcentre through mu and nu

``q_certainty`` and ``q_centre`` are the walks of the two groups; 0 leaves a group as it is, and with both 0 the block
is :mod:`leadscrew.controllers._sofnn.network` to the last digits. The centres are kept in order and ``gap`` apart, the
outer ones fixed, so that the sets cover the universe whatever is learned; certainties stay between 0.1 and 10.

**When not to use it**: it learns what the consequents learn already. With a small walk nothing is gained; with a large
one the memberships wander to where no one would call them small any more, and the rules lose their meaning.

``forgetting`` below 1 divides the covariance by it before each update, as textbooks do. It is there to be shown: where
nothing excites a rule its variance then grows without end, unless ``cap`` holds it.

Signals, scales, correction and safeguards as in :mod:`leadscrew.controllers._sofnn.network`; its learner is the Kalman
filter. Bumpless start likewise, from the prior, even centres and certainties of one.

Source: the three groups of weights of the paper of the study ``sofnn_tangent`` (Deng, Liu, Wu, Zhang), section 2; how
they act and learn is our reading.
"""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple, cast

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
from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit
from leadscrew.neural.groups import SIZE, learn_all, said_by, triangle_of
from leadscrew.neural.inference_net import CENTRES, W0
from leadscrew.neural.performance import GOLDEN, TABLE, Performance

EVEN = CENTRES
"""The centres before learning."""
CERTAIN = np.ones(49)
"""The certainties before learning."""
UNSURE = triangle_of(np.diag(np.repeat([1.0, 0.0], [49, SIZE - 49])))
"""The covariance before learning: only the consequents are open, the others become so by their walks."""

Walk = Annotated[float, Ge(0), Le(10), Doc("random walk of a parameter of this group a sample; 0: not learned")]


class AllWeightsParams(NamedTuple):
    """As :class:`~leadscrew.controllers._sofnn.network.SofnnParams`, and the two further groups."""

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
    r: Annotated[float, Ge(1e-9), Le(1e6), Doc("variance of a target, levels squared, R")] = 0.01
    q: Annotated[float, Ge(0), Le(1e3), Doc("random walk of a consequent, levels squared a sample, Q")] = 0.05
    cap: Annotated[float, Gt(0), Le(1e300), Doc("largest variance of a parameter")] = 4.0
    q_centre: Walk = 0.0
    q_certainty: Walk = 0.0
    gap: Annotated[float, Unit("1"), Gt(0), Le(2), Doc("least distance of two centres, levels")] = 0.4
    passes: Annotated[int, Ge(1), Le(5), Doc("updates a sample, at most; the inner loop of step (7)")] = 1
    tolerance: Annotated[float, Ge(0), Le(1e3), Doc("J below which no update is made, levels squared")] = 0.0
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
    centres_e: Annotated[np.ndarray, Doc("seven centres of E, levels")] = EVEN
    centres_ec: Annotated[np.ndarray, Doc("seven centres of EC, levels")] = EVEN
    covariance: Annotated[np.ndarray, Doc("of all 108 parameters, P; lower triangle")] = UNSURE
    past_e: PastE = np.zeros(ROOM)
    past_ec: PastEC = np.zeros(ROOM)
    past_d: PastD = np.zeros(ROOM)
    at: At = 0
    offset: Annotated[float, Unit("deg"), Doc("offset sent, d")] = 0.0
    aligned: Aligned = 0
    short: Short = 0.0


def ready(params: AllWeightsParams, dt: float) -> AllWeightsPlan:
    """The parameters as the step reads them."""
    kalman = Filter(
        int(params.target), params.r, params.q, params.q_certainty, params.q_centre, params.cap, params.clamp,
        params.gap, params.passes, params.tolerance, params.forgetting,
    )  # fmt: skip
    return AllWeightsPlan(scales(params, dt), measure(params), kalman, np.array(params.prior, dtype=float))


def learn(p, s, e, ec, stored, g):
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


def align(params, command, feedback, output):
    """The state from which the next output is ``output``: the prior; a step that sees shifts the rules that fire."""
    watch = taken_over(command, feedback)
    return AllWeightsState(
        watch, params.prior, CERTAIN, EVEN, EVEN, UNSURE, NOTHING, NOTHING, NOTHING, 0, output, 1, 0.0
    )  # fmt: skip


@controller(AllWeightsParams, AllWeightsState, prepare=ready, align=align, unit="deg", drive="position")
def sofnn_all_weights(p, s, command, feedback, dt):
    """Self-organising network that learns consequents, certainties and membership centres; an offset angle."""
    watch = watched(p.scales, s.watch, command, feedback)
    e = p.scales.k_e * watch.error
    ec = p.scales.k_ec * watch.rate
    g = rectified(p.measure, watch.error, e, ec)
    if s.aligned == 1 and watch.blind == 0:
        here = said_by(s.weights, s.certainties, s.centres_e, s.centres_ec, e, ec).fired
        shifted(s.weights, here, held(s.offset / p.scales.k_d, 6.0), p.measure.clamp)
    if learns(p.measure, p.scales.most, watch.known, s.offset, g):
        then = place_before(s.at, p.measure.delay)
        learn(p.filter, s, s.past_e[then], s.past_ec[then], s.past_d[then], g)
        if p.measure.leak > 0.0:
            leak(s.weights, p.prior, p.measure.leak)
    said = said_by(s.weights, s.certainties, s.centres_e, s.centres_ec, e, ec)
    level = held(said.level, 6.0)
    short = lacking(p.scales, s.watch.blind, s.aligned, s.short, level, s.offset)
    offset = sent(p.scales, watch, level, short, s.offset)
    s.past_e[s.at] = e
    s.past_ec[s.at] = ec
    s.past_d[s.at] = level
    return AllWeightsState(
        watch, s.weights, s.certainties, s.centres_e, s.centres_ec, s.covariance, s.past_e, s.past_ec, s.past_d,
        place_after(s.at), offset, 0, short,
    ), offset  # fmt: skip


cast(Any, sofnn_all_weights.step).takes_cut_line = True
