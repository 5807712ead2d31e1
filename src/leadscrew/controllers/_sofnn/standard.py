"""Standard self-organising fuzzy controller (SOFC) of a tangential knife: the table corrects the 49 rules directly.

    w_k += a_k(k - m_c) g(k)                                   the rules that fired m_c samples ago, each by its part
    w_k += a_k(k - m_c) (D(k - m_c) + g(k) - what they say now)      target = 0
    D(k) = clip(sum a_k(k) w_k, -6, 6),   d(k) = clip(k_d D(k), -most, most)

No network, no Kalman filter: each of the at most four rules that caused what is seen now is credited with the
correction in proportion to its part in it. What was said then becomes ``g sum a_k^2`` more, between a quarter of ``g``
(between four rules) and all of it (on a rule's peak).

T. J. Procyk, E. H. Mamdani, *A linguistic self-organizing process controller*, Automatica 15, 1979, put in the place of
the rules that fired the one that should have fired: what was said then plus the correction (``target = 0``, equation
(3) of the paper). Later forms add the correction to what the rule says now (the default; J. Jantzen, *The
self-organising fuzzy controller*, Technical University of Denmark, 1998, to the one cell responsible). The paper
of the study ``sofnn_tangent`` does not spell the law out: the weighting by firing strength is our choice. The rules at
the start are the untrained ones, as there is no network to train.

Everything else, safeguards too, as in :mod:`leadscrew.controllers._sofnn.network`. Bumpless start in the same way.
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
from leadscrew.fuzzy.inference import Axis
from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc, Unit
from leadscrew.neural.inference_net import AXIS, fired, initial_rules, network_output
from leadscrew.neural.performance import GOLDEN, TABLE, Performance

RULES = initial_rules().ravel()
"""The untrained rules."""


class SofcParams(NamedTuple):
    """Scales, correction, safeguards."""

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
    target: Target = 1
    delay: Delay = 6
    dead_zone: DeadZone = 0.0
    leak: Leak = 0.001
    clamp: Clamp = 6.0
    prior: Rules = RULES
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
    weights: Weights = RULES
    past_e: PastE = np.zeros(ROOM)
    past_ec: PastEC = np.zeros(ROOM)
    past_d: PastD = np.zeros(ROOM)
    at: At = 0
    offset: Annotated[float, Unit("deg"), Doc("offset sent, d")] = 0.0
    aligned: Aligned = 0
    short: Short = 0.0


def ready(params: SofcParams, dt: float) -> SofcPlan:
    """The parameters as the step reads them."""
    return SofcPlan(scales(params, dt), AXIS, measure(params), int(params.target), np.array(params.prior, dtype=float))


def credit(weights, past, g, clamp):
    """Corrects the four rules that fired, each by ``g`` times its firing strength, in place."""
    k = 7 * past.j + past.i
    weights[k] = held(weights[k] + (1.0 - past.nu) * (1.0 - past.mu) * g, clamp)
    weights[k + 1] = held(weights[k + 1] + (1.0 - past.nu) * past.mu * g, clamp)
    weights[k + 7] = held(weights[k + 7] + past.nu * (1.0 - past.mu) * g, clamp)
    weights[k + 8] = held(weights[k + 8] + past.nu * past.mu * g, clamp)
    return g


def align(params, command, feedback, output):
    """The state from which the next output is ``output``: the prior; a step that sees shifts the rules that fire."""
    watch = taken_over(command, feedback)
    return SofcState(watch, params.prior, NOTHING, NOTHING, NOTHING, 0, output, 1, 0.0)


@controller(SofcParams, SofcState, prepare=ready, align=align, unit="deg", drive="position")
def sofc(p, s, command, feedback, dt):
    """Standard self-organising fuzzy controller: a table corrects its 49 rules as it cuts; an offset angle."""
    watch = watched(p.scales, s.watch, command, feedback)
    e = p.scales.k_e * watch.error
    ec = p.scales.k_ec * watch.rate
    g = rectified(p.measure, watch.error, e, ec)
    if s.aligned == 1 and watch.blind == 0:
        shifted(s.weights, fired(p.axis, p.axis, e, ec), held(s.offset / p.scales.k_d, 6.0), p.measure.clamp)
    if learns(p.measure, p.scales.most, watch.known, s.offset, g):
        then = place_before(s.at, p.measure.delay)
        past = fired(p.axis, p.axis, s.past_e[then], s.past_ec[then])
        owed = s.past_d[then] - network_output(s.weights, past) if p.target == 0 else 0.0
        credit(s.weights, past, owed + g, p.measure.clamp)
        if p.measure.leak > 0.0:
            leak(s.weights, p.prior, p.measure.leak)
    level = held(network_output(s.weights, fired(p.axis, p.axis, e, ec)), 6.0)
    short = lacking(p.scales, s.watch.blind, s.aligned, s.short, level, s.offset)
    offset = sent(p.scales, watch, level, short, s.offset)
    s.past_e[s.at] = e
    s.past_ec[s.at] = ec
    s.past_d[s.at] = level
    return SofcState(watch, s.weights, s.past_e, s.past_ec, s.past_d, place_after(s.at), offset, 0, short), offset


cast(Any, sofc.step).takes_cut_line = True
