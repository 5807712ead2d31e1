"""The paper's 49 rules, asked about the line instead of the error: what they learn can be kept.

    E = k_c kappa          EC = k_h (kappa - kappa smoothed over highpass_s)                   levels, -6..6
    D = sum a_r(E, EC) w_r + w_50 sin 2 phi + w_51 cos 2 phi                                   level of the offset
    i = -(y(k) - g x(k - m)) / (g k_d) - D(s)          what was needed at s = k - m - 1, less what the rules say there
    w += P h i / q        P -= P h (P h)' / q        q = h' P h + noise                        h: the 6 that act at s
    d = clip(k_d (D(k + preview) + gain z), -max_offset, max_offset)    z: i, through a lag of filter_s

The rules of the error (:func:`leadscrew.controllers.sofnn`) say how to go on from an error, so frozen they keep
a third of what they gained: they act as an integrator. Rules of the curvature say what this material does to a line of
this shape; frozen, they know it on this line and on others. Network and Kalman update are those of
:mod:`leadscrew.neural`. The target is direct (the offset that was needed is measured): nothing has to walk, no ``Q``.

Two things are added to plain rules, both through ``prior_covariance`` alone (:func:`start_covariance`):

- the two **direction** terms, for the fibre. A variance of 0 leaves them out.
- rules that know of each other. With ``P_0 = I`` a rule that has never fired stays at 0, and a sharper curve than the
  learned ones gets no offset. Here the rules start as a plane through 0 of unknown slopes plus a little roughness that
  is alike in neighbours, so that rules that never fired follow the plane that the others show.

``prior`` and ``prior_covariance`` carry what was learned from piece to piece. ``learning = "off"`` freezes it. Learning
and ``z`` stand still while the cut is not seen and while the last offset was at its limit; what is read then, even NaN,
is not used. Seen again, both take a share of each reading that grows to all of it within ``return_s``.

The scales, the high-pass and the start were chosen on other lines and seeds than the study's
(``studies/sofnn_tangent/curvature_rules.py``). They matter: a high-pass of 0.06 s doubles what is left on a line that
was not learned. ``k_c`` and ``k_h`` of 24 mm bring curves of 4 mm radius to the outermost rules.

Takes the command of :obj:`leadscrew.references.cut_line` and the reading of
:func:`leadscrew.sensors.cut_reading`. Bumpless start: ``z`` is set so that the next output is the last one
(with ``gain = 0`` it cannot), and nothing is learned until the way behind is known.

Source: ours, for the study ``sofnn_tangent``; network and filter are its paper's.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal, NamedTuple

import numpy as np

from leadscrew.controllers._tangent.believed import (
    MOST_DEG,
    RING,
    TWICE,
    AxisLag,
    FilterS,
    MaxOffset,
    ObserverGain,
    PlantGain,
    Preview,
    ReturnS,
    SensorDelay,
    acting,
    back,
    checked_prior,
    next_place,
    quiet,
    samples,
    start_from_prior,
    trusted,
    within,
)
from leadscrew.fuzzy.inference import Axis
from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit
from leadscrew.neural.inference_net import AXIS, CLAMP, RULES, SETS, fired, network_output, strengths

COUNT = RULES + 2
"""Weights: 49 rules, then sin 2 phi and cos 2 phi."""


def start_covariance(
    level: float = 0.03, slope: float = 0.3, rough: float = 0.01, reach: float = 1.5, direction: float = 0.1
) -> np.ndarray:
    """Covariance of the 51 weights before anything is known, level^2.

    Rules ``a`` and ``b`` at ``(i, j)`` and ``(k, l)``, -3..3, have the covariance ``level + slope (i k + j l) + rough
    exp(-((i - k)^2 + (j - l)^2) / (2 reach^2))``: a plane of unknown height and slopes, and a roughness that reaches
    over ``reach`` rules. ``direction`` is the variance of each of the two terms of the direction.
    """
    i, j = np.arange(RULES) % SETS - 3.0, np.arange(RULES) // SETS - 3.0
    apart = (i[:, None] - i) ** 2 + (j[:, None] - j) ** 2
    found = direction * np.eye(COUNT)
    plane = level + slope * (np.outer(i, i) + np.outer(j, j))
    found[:RULES, :RULES] = plane + rough * (np.exp(-0.5 * apart / reach**2) + 1e-3 * np.eye(RULES))
    return found


def apart_covariance(variance: float = 1.0) -> np.ndarray:
    """Every rule for itself, and no direction."""
    found = np.zeros((COUNT, COUNT))
    found[:RULES, :RULES] = variance * np.eye(RULES)
    return found


Scale = Annotated[float, Unit("mm"), Ge(0), Doc("level of a curvature of 1/mm")]


class CurvatureNetworkParams(NamedTuple):
    """Rules, learning, observer, and what is believed of the axis."""

    prior: Annotated[np.ndarray, Doc("weights at the start, levels")] = np.zeros(COUNT)
    prior_covariance: Annotated[np.ndarray, Doc("of the weights at the start, level^2; symmetric")] = start_covariance()
    k_c: Scale = 24.0
    k_h: Scale = 24.0
    highpass_s: Annotated[float, Unit("s"), Gt(0), Le(10), Doc("time over which the curvature is smoothed")] = 0.1
    k_d: Annotated[float, Unit("deg"), Gt(0), Doc("offset of one level")] = 2.5
    noise: Annotated[float, Gt(0), Doc("variance of what is learned from, level^2")] = 0.05
    learning: Annotated[Literal["off", "on"] | int, Doc("whether it learns; off keeps the prior")] = 1
    gain: ObserverGain = 0.8
    filter_s: FilterS = 0.02
    return_s: ReturnS = 0.1
    preview: Preview = 1
    plant_gain: PlantGain = 0.9
    axis_lag_s: AxisLag = 0.02
    delay_s: SensorDelay = 0.04
    max_offset: MaxOffset = MOST_DEG


class CurvatureNetworkPlan(NamedTuple):
    """Shares per period and delays in samples."""

    prior: np.ndarray
    prior_covariance: np.ndarray
    levels: Axis
    k_c: float
    k_h: float
    smooth: float
    k_d: float
    noise: float
    learning: float
    gain: float
    filtered: float
    returns: float
    old: int
    plant_gain: float
    axis: float
    late: int
    max_offset: float
    empty: np.ndarray


class CurvatureNetworkState(NamedTuple):
    """What was learned, the way behind, the axis as believed and the observer."""

    weights: Annotated[np.ndarray, Doc("w, levels")]
    covariance: Annotated[np.ndarray, Doc("P, level^2")]
    curvatures: Annotated[np.ndarray, Doc("E of the line ahead, levels")]
    changes: Annotated[np.ndarray, Doc("EC of the line ahead, levels")]
    headings: Annotated[np.ndarray, Doc("of the line ahead, deg")]
    places: Annotated[np.ndarray, Doc("angles of the axis, as believed, deg")]
    at: Annotated[int, Doc("place in the rings")] = 0
    wait: Annotated[int, Doc("samples until learning starts; -1 before the first, -2 before that of a takeover")] = -1
    smoothed: Annotated[float, Unit("1/mm"), Doc("curvature ahead, smoothed")] = 0.0
    axis: Annotated[float, Unit("deg"), Doc("angle of the axis, as believed")] = 0.0
    found: Annotated[float, Doc("what the rules do not explain, z, levels")] = 0.0
    sent: Annotated[float, Unit("deg"), Doc("offset of the last period")] = 0.0
    sight: Annotated[float, Doc("share of a reading that is taken")] = 1.0


def plan(params: CurvatureNetworkParams, dt: float) -> CurvatureNetworkPlan:
    """Shares per period and delays.

    Raises:
        ValueRefused: a prior of the wrong shape, or one whose covariance is not symmetric.
    """
    prior, covariance = checked_prior(params, COUNT, "curvature_network")
    old = 1 + params.preview
    late = samples(params.delay_s, dt, old, "curvature_network")
    return CurvatureNetworkPlan(
        prior, covariance, AXIS, params.k_c, params.k_h, -math.expm1(-dt / params.highpass_s),
        params.k_d, params.noise, float(params.learning), params.gain, -math.expm1(-dt / params.filter_s),
        dt / params.return_s, late + old, params.plant_gain, -math.expm1(-dt / params.axis_lag_s), late,
        params.max_offset, np.zeros(RING),
    )  # fmt: skip


def align(params, command, feedback, output):
    """The state from which the next output is ``output``; its arrays are filled in that step."""
    p = params
    return CurvatureNetworkState(
        p.prior, p.prior_covariance, p.empty, p.empty, p.empty, p.empty, 0, -2,
        command.curvature, output, 0.0, output,
    )  # fmt: skip


def begun(p, s):
    """Empties the rings, and takes the prior."""
    for i in range(RING):
        s.curvatures[i] = 0.0
        s.changes[i] = 0.0
        s.headings[i] = 0.0
        s.places[i] = s.axis
    return start_from_prior(p, s)


def said(s, rules, heading):
    """Level of the offset that the weights say."""
    return (
        network_output(s.weights, rules)
        + s.weights[RULES] * math.sin(TWICE * heading)
        + s.weights[RULES + 1] * math.cos(TWICE * heading)
    )


def learned(p, s, rules, heading, inn, on):
    """The share ``on`` of one Kalman update of all 51 weights, in place."""
    k = 7 * rules.j + rules.i
    h = strengths(rules)
    turned, across = math.sin(TWICE * heading), math.cos(TWICE * heading)
    gained = np.zeros(51)
    for i in range(COUNT):
        gained[i] = (
            h.h0 * s.covariance[k, i]
            + h.h1 * s.covariance[k + 1, i]
            + h.h2 * s.covariance[k + 7, i]
            + h.h3 * s.covariance[k + 8, i]
            + turned * s.covariance[RULES, i]
            + across * s.covariance[RULES + 1, i]
        )
    q = (
        h.h0 * gained[k] + h.h1 * gained[k + 1] + h.h2 * gained[k + 7] + h.h3 * gained[k + 8]
        + turned * gained[RULES] + across * gained[RULES + 1] + p.noise
    )  # fmt: skip
    root = on / math.sqrt(q)
    for i in range(COUNT):
        s.weights[i] = within(s.weights[i] + on * gained[i] * inn / q, CLAMP)
        gained[i] = root * gained[i]
    for i in range(COUNT):
        for j in range(COUNT):
            s.covariance[i, j] = s.covariance[i, j] - gained[i] * gained[j]
    return q


@controller(
    CurvatureNetworkParams(),
    CurvatureNetworkState(
        np.zeros(COUNT), np.zeros((COUNT, COUNT)), np.zeros(RING), np.zeros(RING), np.zeros(RING), np.zeros(RING)
    ),
    prepare=plan, align=align, unit="deg", drive="position",
)  # fmt: skip
def curvature_network(p, s, command, feedback, dt):
    """49 fuzzy rules of the curvature, learned as it cuts, with an observer of the rest; an offset in deg."""
    took_over = 1.0 if s.wait == -2 else 0.0
    if s.wait < 0:
        begun(p, s)
    smoothed = s.smoothed + p.smooth * (command.curvature_ahead - s.smoothed)
    s.curvatures[s.at] = p.k_c * command.curvature_ahead
    s.changes[s.at] = p.k_h * (command.curvature_ahead - smoothed)
    s.headings[s.at] = command.heading_ahead
    s.places[s.at] = s.axis
    wait = p.old if s.wait < 0 else s.wait
    then = fired(p.levels, p.levels, back(s.curvatures, s.at, p.old), back(s.changes, s.at, p.old))
    heading = back(s.headings, s.at, p.old)
    sight = trusted(s.sight, feedback.seen, p.returns)
    reading = feedback.deviation if feedback.seen > 0.5 else 0.0
    needed = -(reading - command.deviation - p.plant_gain * back(s.places, s.at, p.late)) / p.plant_gain
    inn = needed / p.k_d - said(s, then, heading)
    acts = acting(p, s, wait, sight)
    if acts * p.learning > 0.0:
        learned(p, s, then, heading, inn, acts)
    ahead = said(s, fired(p.levels, p.levels, s.curvatures[s.at], s.changes[s.at]), command.heading_ahead)
    found = s.found + acts * p.filtered * (inn - s.found)
    found = (s.sent / p.k_d - ahead) / max(p.gain, 1e-9) if took_over > 0.5 else found
    d = within(p.k_d * (ahead + p.gain * found), p.max_offset)
    return CurvatureNetworkState(
        s.weights, s.covariance, s.curvatures, s.changes, s.headings, s.places, next_place(s.at), max(wait - 1, 0),
        quiet(smoothed), quiet(s.axis + p.axis * (d - s.axis)), quiet(found), d, sight,
    ), d  # fmt: skip


curvature_network.step.takes_cut_line = True  # type: ignore[attr-defined]
