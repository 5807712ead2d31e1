"""Adaptive feed-forward of curvature: what a line of this shape does to the cut in this material, learned and undone.

    f(s)  = [30 kappa(s - l_1), ..., 30 kappa(s - l_4), sin 2 phi(s), cos 2 phi(s), 1]         lags l in samples
    c(k)  = y(k) - g x(k - m)           what the offset does not explain of the reading, of the place s = k - m - 1
    i     = c(k) - f(s) w               a = P f(s)               q = f(s) a + forgetting noise
    w    += a i / q                     P = (P - a a' / q) / forgetting, scaled so that its trace stays below trace_cap
    z    += (1 - e^(-T / filter_s)) (i - z)                                       what the weights do not explain
    d(k)  = clip(-(f(k + preview) w + gain z) / g, -max_offset, max_offset)

Recursive least squares of seven weights (deg). The material answers a curvature late, and the four lags let the
weights form its answer; ``sin 2 phi`` and ``cos 2 phi`` are the fibre, 1 the bevel. ``preview`` makes up for the lag of
the axis. The reading of now is of the place that the blade left ``m`` samples ago (the offset of a period acts to its
end, hence the 1).

``prior`` and ``prior_covariance`` are what it starts from: nothing known (zeros, and 0.03 on the diagonal: a larger one
lets the first noise in), the weights and covariance of the piece before, or what other materials have in common
(:mod:`leadscrew.studies.sofnn_tangent.pieces`). The shape is exact only while the material is linear in the curvature.

Safe form: ``P`` stays symmetric to the bit, and its trace bounded where nothing excites it. Weights stay within
``weight_limit``. Learning and ``z`` stand still while the cut is not seen and while the last offset was at its limit;
what is read then, even NaN, is not used. Seen again, learning and ``z`` take a share of each reading that grows to all
of it within ``return_s``: what the loss has left over is no jump of the offset.
Before the line there is no curvature; with ``before = "first_sample"`` that of the first sample.

Takes the command of :obj:`leadscrew.references.cut_line` and the reading of
:func:`leadscrew.sensors.cut_reading`. Bumpless start: ``z`` is set so that the next output is the last one
(with ``gain = 0`` it cannot), and nothing is learned until the lags are filled.

Source: ours, not the paper's of the study ``sofnn_tangent``. Recursive least squares with forgetting:
K. J. Astrom, B. Wittenmark, *Adaptive Control*, 2nd ed., chapter 2.
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
from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc, Gt, Le, Unit
from leadscrew.util.errors import ValueRefused

COUNT = 7
"""Weights."""
LAGS = 4
"""Of them of curvatures."""
SCALE = 30.0
"""mm: brings curvatures to the size of the other regressors."""
START = 0.03
"""deg^2: variance of a weight that nothing is known of."""

Covariance = Annotated[np.ndarray, Unit("deg^2"), Doc("of the weights at the start; symmetric")]


class CurvatureFeedForwardParams(NamedTuple):
    """Regressors, learning, observer, and what is believed of the axis."""

    prior: Annotated[np.ndarray, Unit("deg"), Doc("weights at the start")] = np.zeros(COUNT)
    prior_covariance: Covariance = START * np.eye(COUNT)
    lags: Annotated[np.ndarray, Doc("of the curvatures, in samples, ascending")] = np.array([0.0, 3.0, 8.0, 16.0])
    forgetting: Annotated[float, Gt(0.9), Le(1), Doc("share of what is known that a sample keeps")] = 0.998
    noise: Annotated[float, Unit("deg^2"), Gt(0), Doc("variance of what is learned from, R")] = 0.05
    trace_cap: Annotated[float, Unit("deg^2"), Gt(0), Doc("largest trace of the covariance")] = 10.0
    weight_limit: Annotated[float, Unit("deg"), Gt(0), Doc("largest weight, either way")] = 30.0
    learning: Annotated[Literal["off", "on"] | int, Doc("whether it learns; off keeps the prior")] = 1
    gain: ObserverGain = 0.8
    filter_s: FilterS = 0.02
    return_s: ReturnS = 0.1
    preview: Preview = 1
    before: Annotated[Literal["none", "first_sample"] | int, Doc("curvature that is taken before the line")] = 0
    plant_gain: PlantGain = 0.9
    axis_lag_s: AxisLag = 0.02
    delay_s: SensorDelay = 0.04
    max_offset: MaxOffset = MOST_DEG


class CurvatureFeedForwardPlan(NamedTuple):
    """Shares per period and delays in samples."""

    prior: np.ndarray
    prior_covariance: np.ndarray
    lags: np.ndarray
    keep: float
    noise: float
    trace_cap: float
    weight_limit: float
    learning: float
    gain: float
    filtered: float
    returns: float
    old: int
    fill: int
    before: float
    plant_gain: float
    axis: float
    late: int
    max_offset: float
    empty: np.ndarray


class CurvatureFeedForwardState(NamedTuple):
    """What was learned, the way behind, the axis as believed and the observer."""

    weights: Annotated[np.ndarray, Doc("w, deg")]
    covariance: Annotated[np.ndarray, Doc("P, deg^2")]
    curvatures: Annotated[np.ndarray, Doc("of the line ahead, 1/mm")]
    headings: Annotated[np.ndarray, Doc("of the line ahead, deg")]
    places: Annotated[np.ndarray, Doc("angles of the axis, as believed, deg")]
    at: Annotated[int, Doc("place in the rings")] = 0
    wait: Annotated[int, Doc("samples until learning starts; -1 before the first, -2 before that of a takeover")] = -1
    axis: Annotated[float, Unit("deg"), Doc("angle of the axis, as believed")] = 0.0
    found: Annotated[float, Unit("deg"), Doc("what the weights do not explain, z")] = 0.0
    sent: Annotated[float, Unit("deg"), Doc("offset of the last period")] = 0.0
    sight: Annotated[float, Doc("share of a reading that is taken")] = 1.0


def plan(params: CurvatureFeedForwardParams, dt: float) -> CurvatureFeedForwardPlan:
    """Shares per period and delays.

    Raises:
        ValueRefused: lags that are not whole, ascending and short enough; a prior of the wrong shape or one whose
            covariance is not symmetric.
    """
    lags = np.asarray(params.lags, dtype=float)
    good = lags.shape == (LAGS,) and (lags == np.round(lags)).all() and lags[0] >= 0 and (np.diff(lags) > 0).all()
    if not good:
        raise ValueRefused(f"lags = {lags.tolist()} (curvature_feed_forward): expected 4 whole numbers, ascending")
    prior, covariance = checked_prior(params, COUNT, "curvature_feed_forward")
    old = 1 + params.preview
    late = samples(params.delay_s, dt, old + int(lags[-1]), "curvature_feed_forward")
    return CurvatureFeedForwardPlan(
        prior, covariance, lags, params.forgetting, params.noise, params.trace_cap,
        params.weight_limit, float(params.learning), params.gain, -math.expm1(-dt / params.filter_s),
        dt / params.return_s, late + old, late + old + int(lags[-1]), float(params.before), params.plant_gain,
        -math.expm1(-dt / params.axis_lag_s), late, params.max_offset, np.zeros(RING),
    )  # fmt: skip


def align(params, command, feedback, output):
    """The state from which the next output is ``output``; its arrays are filled in that step."""
    p = params
    return CurvatureFeedForwardState(p.prior, p.prior_covariance, p.empty, p.empty, p.empty, 0, -2, output, 0.0, output)


def begun(p, s, command, way):
    """Fills the rings with what was before the line, and takes the prior."""
    for i in range(RING):
        s.curvatures[i] = way * command.curvature
        s.headings[i] = command.heading
        s.places[i] = s.axis
    s.curvatures[RING - 1] = command.curvature
    return start_from_prior(p, s)


def regressor(p, s, at, late, i):
    """Regressor ``i`` of the place ``late`` samples behind the one that was seen last."""
    heading = TWICE * back(s.headings, at, late)
    turn = math.sin(heading) if i == LAGS else (math.cos(heading) if i == LAGS + 1 else 1.0)
    return SCALE * back(s.curvatures, at, late + int(p.lags[min(i, LAGS - 1)])) if i < LAGS else turn


@controller(
    CurvatureFeedForwardParams(),
    CurvatureFeedForwardState(
        np.zeros(COUNT), np.zeros((COUNT, COUNT)), np.zeros(RING), np.zeros(RING), np.zeros(RING)
    ),
    prepare=plan, align=align, unit="deg", drive="position",
)  # fmt: skip
def curvature_feed_forward(p, s, command, feedback, dt):
    """Adaptive feed-forward of curvature and direction, with an observer of the rest; an offset in deg."""
    took_over = 1.0 if s.wait == -2 else 0.0
    if s.wait < 0:
        begun(p, s, command, max(took_over, p.before))
    s.curvatures[s.at] = command.curvature_ahead
    s.headings[s.at] = command.heading_ahead
    s.places[s.at] = s.axis
    wait = (p.late + 1 if s.wait == -1 else p.fill + 1) if s.wait < 0 else s.wait
    here = np.zeros(7)
    gained = np.zeros(7)
    told = 0.0
    for i in range(COUNT):
        here[i] = regressor(p, s, s.at, p.old, i)
        told = told + s.weights[i] * here[i]
    sight = trusted(s.sight, feedback.seen, p.returns)
    reading = feedback.deviation if feedback.seen > 0.5 else 0.0
    inn = reading - command.deviation - p.plant_gain * back(s.places, s.at, p.late) - told
    acts = acting(p, s, wait, sight)
    learns = acts * p.learning
    q = p.keep * p.noise
    for i in range(COUNT):
        total = 0.0
        for j in range(COUNT):
            total = total + s.covariance[i, j] * here[j]
        gained[i] = total
        q = q + total * here[i]
    trace = 0.0
    for i in range(COUNT):
        s.weights[i] = within(s.weights[i] + learns * gained[i] * inn / q, p.weight_limit)
        trace = trace + (s.covariance[i, i] - learns * gained[i] * gained[i] / q)
    keep = 1.0 - learns * (1.0 - p.keep)
    scale = min(1.0 / keep, p.trace_cap / trace) if trace > 0.0 and learns > 0.0 else 1.0
    for i in range(COUNT):
        for j in range(COUNT):
            s.covariance[i, j] = scale * (s.covariance[i, j] - learns * (gained[i] * gained[j]) / q)
    ahead = 0.0
    for i in range(COUNT):
        ahead = ahead + s.weights[i] * regressor(p, s, s.at, 0, i)
    found = s.found + acts * p.filtered * (inn - s.found)
    held = (-s.sent * p.plant_gain - ahead) / max(p.gain, 1e-9)
    found = held if took_over > 0.5 else found
    d = within(-(ahead + p.gain * found) / p.plant_gain, p.max_offset)
    return CurvatureFeedForwardState(
        s.weights, s.covariance, s.curvatures, s.headings, s.places, next_place(s.at), max(wait - 1, 0),
        quiet(s.axis + p.axis * (d - s.axis)), quiet(found), d, sight,
    ), d  # fmt: skip


curvature_feed_forward.step.takes_cut_line = True  # type: ignore[attr-defined]
