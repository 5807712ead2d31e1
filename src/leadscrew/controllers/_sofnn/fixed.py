"""Fixed fuzzy network of a tangential knife: 49 rules on the deviation and its change, positional.

    E = k_e e,  EC = k_ec ec        D = sum a_k w_k,  a_k = mu_i(E) nu_j(EC)        d = clip(k_d D)

Four rules fire at most and the ``a_k`` sum to one, so ``D`` is the bilinear interpolation of the 49 consequents ``w``
(levels, number ``7 j + i``): :mod:`leadscrew.neural.inference_net`. The ``rules`` are those after Kalman training; the
untrained ones (:func:`~leadscrew.neural.inference_net.initial_rules`) make it a plain fuzzy controller.

**What it can do**: the rules are a map without memory, of slope about -1 at the origin, so of a slow deviation it takes
away ``1 - 1 / (1 + g k_d k_e)`` for a cut that turns ``g`` times the offset: 14 % at the paper's scales, g = 1.

Bumpless start: it goes on from the last output and fades from there to what the rules say, with ``fade_s``.

Source: equations (1) and (2) of the paper of the study ``sofnn_tangent`` (Deng, Liu, Wu, Zhang). Scales from its
ranges; memberships and rules are the study's reconstruction.
"""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple, cast

import numpy as np

from leadscrew.controllers._sofnn.levels import (
    KD,
    KE,
    KEC,
    MOST_LEVEL,
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
from leadscrew.fuzzy.inference import Axis
from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc, Ge, Le, Unit
from leadscrew.neural.inference_net import AXIS, W0, fired, network_output

Rules = Annotated[np.ndarray, Ge(-MOST_LEVEL), Le(MOST_LEVEL), Doc("49 consequents, levels; number 7 EC + E, from NB")]


class FnnParams(NamedTuple):
    """Scales and rules."""

    k_e: KE = 6.0 / 90.0
    k_ec: KEC = 6.0 / 90.0
    per_second: PerSecond = False
    k_d: KD = 2.5
    filter_s: FilterS = 0.05
    most: Most = 15.0
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
    offset: Annotated[float, Unit("deg"), Doc("offset sent, d")] = 0.0
    aligned: Aligned = 0
    short: Short = 0.0


def ready(params: FnnParams, dt: float) -> FnnPlan:
    """The parameters as the step reads them."""
    return FnnPlan(scales(params, dt), AXIS, np.array(params.rules, dtype=float))


def align(params, command, feedback, output):
    """The state from which the next output is ``output``."""
    return FnnState(taken_over(command, feedback), output, 1, 0.0)


@controller(FnnParams, FnnState, prepare=ready, align=align, unit="deg", drive="position")
def fnn(p, s, command, feedback, dt):
    """Fixed fuzzy network of 49 rules on the deviation of the cut and its change; an offset angle."""
    watch = watched(p.scales, s.watch, command, feedback)
    here = fired(p.axis, p.axis, p.scales.k_e * watch.error, p.scales.k_ec * watch.rate)
    level = held(network_output(p.rules, here), 6.0)
    short = lacking(p.scales, s.watch.blind, s.aligned, s.short, level, s.offset)
    offset = sent(p.scales, watch, level, short, s.offset)
    return FnnState(watch, offset, 0, short), offset


cast(Any, fnn.step).takes_cut_line = True
