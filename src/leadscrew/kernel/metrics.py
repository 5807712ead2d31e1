"""Metrics of a run: streaming accumulators, so that a batch needs no recording.

A metric's step sees the signals of one period at its start, ``t = k dt``; its value is ``output(p, s)``. Sums are
rectangle sums ``sum(x dt)``, exact for signals held over the period. Everywhere

``error``
    ``command - actual``, the true error of the primary scalar pair;
``from_time``
    samples before it are left out; the sample nearest to it counts, whatever the rounding of ``t``.

A **move** is a run of consecutive periods in which the command changes: a step is a move of one period, a jerk-limited
positioning one of many. The first sample is a move from ``actual`` to ``command`` where the two differ. Overshoot,
rise time and settling time describe the last move of a run.

Units: ``[error]`` and ``[output]`` stand for the unit of that signal in the loop at hand. A metric that has seen no
sample that it could judge is NaN; ``Run.metrics_without_value`` says why.
"""

from __future__ import annotations

import math
import sys
from typing import Annotated, NamedTuple

from leadscrew.kernel.block import Block, metric
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit

NAN = math.nan
UNKNOWN = sys.float_info.max
"""Start, in seconds, of a window that a live loop never reaches."""


class Window(NamedTuple):
    """The part of a run that a metric looks at."""

    from_time: Annotated[float, Unit("s"), Ge(0), Doc("samples before this time are left out")] = 0.0


class LastPart(NamedTuple):
    """The end of a run, which a metric looks at."""

    last_percent: Annotated[
        float, Unit("%"), Gt(0), Le(100), Doc("length of the window, the last part of the run; 100: the whole run")
    ] = 10.0
    from_time: Annotated[float, Unit("s"), Ge(0), Doc("start of the window; 0: that of last_percent")] = 0.0


def last_part(params: LastPart, dt: float, duration: float) -> LastPart:
    """The window's start in a run of ``duration`` seconds; of a run whose end is not known there is no last part."""
    if params.from_time > 0.0:
        return params
    return params._replace(from_time=min((1.0 - 0.01 * params.last_percent) * duration, UNKNOWN))


class Sum(NamedTuple):
    """An integral over the window and the window's length so far."""

    total: float = 0.0
    time: float = 0.0


class Peak(NamedTuple):
    """The largest value in the window so far; negative before the first sample."""

    largest: float = -1.0


def within(p, t, dt):
    """1 from the sample nearest to ``from_time`` on, 0 before."""
    return 1.0 if t > p.from_time - 0.5 * dt else 0.0


def empty_window(p: Window | LastPart, s: object, end: float) -> str:
    """Why a metric has no value that judges every sample of its window."""
    if p.from_time >= UNKNOWN:
        return "the end of a live loop is not known, so it has no last part: set from_time"
    return f"its window holds no sample: from_time = {p.from_time:g} s, and the run ends at {end:g} s"


def few_samples(p: Window, s: object, end: float) -> str:
    """Why a metric has no value that judges the difference of two samples."""
    return f"its window holds fewer than two samples: from_time = {p.from_time:g} s, and the run ends at {end:g} s"


STILL_MOVING = "the command still changes at the end of the run"
NO_MOVE = "the command never changes in this run"


def sign(x):
    """-1, 0 or 1."""
    return 1.0 if x > 0.0 else -1.0 if x < 0.0 else 0.0


def total(p, s):
    """The integral."""
    return s.total if s.time > 0.0 else NAN


def mean(p, s):
    """The integral over the length of the window."""
    return s.total / s.time if s.time > 0.0 else NAN


def root_mean(p, s):
    """The root of the mean."""
    return math.sqrt(s.total / s.time) if s.time > 0.0 else NAN


def largest(p, s):
    """The peak."""
    return s.largest if s.largest >= 0.0 else NAN


@metric(Window(), Sum(), output=root_mean, unit="[error]", no_value=empty_window)
def rms_error(p, s, error, t, dt):
    """Root mean square of the error: ``sqrt(sum(error^2 dt) / sum(dt))``."""
    weight = within(p, t, dt) * dt
    return Sum(s.total + error * error * weight, s.time + weight)


@metric(Window(), Peak(), output=largest, unit="[error]", no_value=empty_window)
def max_error(p, s, error, t, dt):
    """Largest ``|error|``."""
    return Peak(max(s.largest, abs(error) if within(p, t, dt) > 0.0 else -1.0))


@metric(Window(), Sum(), output=total, unit="[error] s", no_value=empty_window)
def iae(p, s, error, t, dt):
    """Integral of ``|error|``."""
    weight = within(p, t, dt) * dt
    return Sum(s.total + abs(error) * weight, s.time + weight)


@metric(Window(), Sum(), output=total, unit="[error]^2 s", no_value=empty_window)
def ise(p, s, error, t, dt):
    """Integral of ``error^2``."""
    weight = within(p, t, dt) * dt
    return Sum(s.total + error * error * weight, s.time + weight)


@metric(Window(), Sum(), output=total, unit="[error] s^2", no_value=empty_window)
def itae(p, s, error, t, dt):
    """Integral of ``(t - from_time) |error|``: give the time of a late step as ``from_time``."""
    weight = within(p, t, dt) * dt
    return Sum(s.total + max(t - p.from_time, 0.0) * abs(error) * weight, s.time + weight)


@metric(LastPart(), Peak(), prepare=last_part, output=largest, unit="[error]", no_value=empty_window)
def steady_state_error(p, s, error, t, dt):
    """Largest ``|error|`` from ``from_time`` on; unless set, in the last 10 % of the run.

    ``last_percent`` sets another part. A live loop has no end: set ``from_time``.
    """
    return Peak(max(s.largest, abs(error) if within(p, t, dt) > 0.0 else -1.0))


@metric(LastPart(), Sum(), prepare=last_part, output=mean, unit="[error]", no_value=empty_window)
def mean_steady_state_error(p, s, error, t, dt):
    """Mean ``|error|`` from ``from_time`` on; unless set, in the last 10 % of the run."""
    weight = within(p, t, dt) * dt
    return Sum(s.total + abs(error) * weight, s.time + weight)


@metric(Window(), Sum(), output=root_mean, unit="[output]", no_value=empty_window)
def effort(p, s, output, t, dt):
    """Root mean square of the controller's output."""
    weight = within(p, t, dt) * dt
    return Sum(s.total + output * output * weight, s.time + weight)


@metric(Window(), Sum(), output=mean, unit="[output]", no_value=empty_window)
def mean_effort(p, s, output, t, dt):
    """Mean ``|output|`` of the controller."""
    weight = within(p, t, dt) * dt
    return Sum(s.total + abs(output) * weight, s.time + weight)


@metric(Window(), Sum(), output=total, unit="[output] s", no_value=empty_window)
def total_effort(p, s, output, t, dt):
    """Integral of ``|output|`` of the controller."""
    weight = within(p, t, dt) * dt
    return Sum(s.total + abs(output) * weight, s.time + weight)


@metric(Window(), Peak(), output=largest, unit="[output]", no_value=empty_window)
def max_output(p, s, output, t, dt):
    """Largest ``|output|`` of the controller."""
    return Peak(max(s.largest, abs(output) if within(p, t, dt) > 0.0 else -1.0))


class Differences(NamedTuple):
    """Squared differences of the output from period to period."""

    total: float = 0.0
    periods: float = 0.0
    last: float = 0.0
    seen: float = 0.0


def root_mean_difference(p, s):
    """The root of the mean squared difference."""
    return math.sqrt(s.total / s.periods) if s.periods > 0.0 else NAN


@metric(Window(), Differences(), output=root_mean_difference, unit="[output] per period", no_value=few_samples)
def chatter(p, s, output, t, dt):
    """Root mean square of ``output_k - output_(k-1)``, both samples inside the window."""
    inside = within(p, t, dt)
    difference = (output - s.last) * s.seen
    return Differences(s.total + difference * difference, s.periods + s.seen, output, inside)


class Crossings(NamedTuple):
    """Changes of sign of the output."""

    crossings: float = 0.0
    start: float = 0.0
    time: float = 0.0
    last_sign: float = 0.0


def rate(p, s):
    """Crossings per second of the window."""
    return s.crossings / s.time if s.time > 0.0 else NAN


@metric(Window(), Crossings(), output=rate, unit="1/s", no_value=empty_window)
def zero_crossing_rate(p, s, output, t, dt):
    """Changes of sign of the controller's output per second of the window.

    A sample that is exactly zero has no sign: the last sign stays, so +, 0, - is one crossing and +, 0, + none.
    """
    inside = within(p, t, dt)
    now = sign(output) * inside
    crossed = 1.0 if now * s.last_sign < 0.0 else 0.0
    start = s.start if s.time > 0.0 else t
    return Crossings(s.crossings + crossed, start, (t - start + dt) * inside, now if now != 0.0 else s.last_sign)


class OvershootState(NamedTuple):
    """The last move's direction and the excess since its last change of command."""

    excess: float = 0.0
    direction: float = 0.0
    last_command: float = 0.0
    seen: float = 0.0
    moving: float = 0.0
    judged: float = 0.0


def excess(p, s):
    """The largest excess; NaN without a move that has ended, or without a sample after it in the window."""
    return s.excess if s.judged > 0.0 and s.direction != 0.0 and s.moving == 0.0 else NAN


def no_overshoot(p: Window, s: OvershootState, end: float) -> str:
    """Why there is no overshoot."""
    return NO_MOVE if s.direction == 0.0 else STILL_MOVING if s.moving > 0.0 else empty_window(p, s, end)


@metric(Window(), OvershootState(), output=excess, unit="[error]", no_value=no_overshoot)
def overshoot(p, s, command, actual, t, dt):
    """Largest excess of ``actual`` beyond ``command`` in the direction of travel, never negative.

    The direction is the sign of the last change of the command (at the first sample: of ``command - actual``), and
    every change of the command starts the count afresh: what is left at the end belongs to the last move. NaN without
    a move, and where the command still changes at the end. Samples before ``from_time`` give a direction but no excess.
    """
    change = command - (s.last_command if s.seen > 0.0 else actual)
    changed = change != 0.0
    direction = sign(change) if changed else s.direction
    inside = within(p, t, dt)
    beyond = direction * (actual - command) * inside
    return OvershootState(
        max(0.0 if changed else s.excess, beyond),
        direction,
        command,
        1.0,
        1.0 if changed else 0.0,
        inside if changed else max(s.judged, inside),
    )


class RiseParams(NamedTuple):
    """The levels between which the rise is timed."""

    low_percent: Annotated[float, Unit("%"), Ge(0), Le(100), Doc("level at which the rise starts")] = 10.0
    high_percent: Annotated[float, Unit("%"), Ge(0), Le(100), Doc("level at which the rise ends")] = 90.0


class RiseState(NamedTuple):
    """When the last move's response passed the two levels; negative: not yet."""

    low_time: float = -1.0
    high_time: float = -1.0
    last_travel: float = 0.0
    origin: float = 0.0
    last_command: float = 0.0
    moving: float = 0.0
    seen: float = 0.0


def passed(level, travel, last_travel, t, dt):
    """When a line from the last sample to this one passes ``level`` upwards; -1 where it does not."""
    up = last_travel <= level and travel >= level and travel > last_travel
    return t - dt * ((travel - level) / (travel - last_travel)) if up else -1.0


def rise(p, s):
    """Time between the levels."""
    return s.high_time - s.low_time if s.low_time >= 0.0 and s.high_time >= 0.0 else NAN


def no_rise(p: RiseParams, s: RiseState, end: float) -> str:
    """Why there is no rise time."""
    if s.moving > 0.0:
        return STILL_MOVING
    if s.last_command == s.origin:
        return NO_MOVE
    if s.high_time < 0.0:
        return f"after the last move the response does not pass {p.high_percent:g} % of it from below"
    return f"the response is past {p.low_percent:g} % of the last move before the command stops changing"


@metric(RiseParams(), RiseState(), output=rise, unit="s", no_value=no_rise)
def rise_time(p, s, command, actual, t, dt):
    """Time that ``actual`` takes from 10 % to 90 % of the last move, each at its first passing.

    The move goes from the command before it (at the first sample: from ``actual``) to the command after it; passings
    are interpolated linearly between samples and counted from the last change of the command on. It is made for
    steps: after a long move ``actual`` is past the low level before the command has stopped, and the value is NaN, as
    it is where the high level was never reached.
    """
    before = s.last_command if s.seen > 0.0 else actual
    changed = command != before
    origin = before if changed and s.moving == 0.0 else s.origin if s.seen > 0.0 else command
    size = command - origin
    travel = sign(size) * (actual - origin)
    low = passed(0.01 * p.low_percent * abs(size), travel, s.last_travel, t, dt)
    high = passed(0.01 * p.high_percent * abs(size), travel, s.last_travel, t, dt)
    return RiseState(
        -1.0 if changed else s.low_time if s.low_time >= 0.0 else low,
        -1.0 if changed else s.high_time if s.high_time >= 0.0 else high,
        travel,
        origin,
        command,
        1.0 if changed else 0.0,
        1.0,
    )


class SettlingParams(NamedTuple):
    """The band; the wider of the two counts."""

    percent: Annotated[float, Unit("%"), Ge(0), Doc("half width of the band in percent of the last move")] = 2.0
    band: Annotated[float, Ge(0), Doc("half width of the band in the unit of the error")] = 0.0


class SettlingState(NamedTuple):
    """When the last move ended and since when the error has been inside the band."""

    start: float = 0.0
    entered: float = 0.0
    inside: float = 0.0
    origin: float = 0.0
    last_command: float = 0.0
    moving: float = 0.0
    seen: float = 0.0


def settled(p, s):
    """Time from the end of the move to the last entry into the band; NaN before the move has ended."""
    return s.entered - s.start if s.inside > 0.0 and s.moving == 0.0 else NAN


def no_settling(p: SettlingParams, s: SettlingState, end: float) -> str:
    """Why there is no settling time."""
    if s.moving > 0.0:
        return STILL_MOVING
    size = abs(s.last_command - s.origin)
    half_width = max(p.band, 0.01 * p.percent * size)
    if half_width == 0.0:
        return f"{NO_MOVE}, so {p.percent:g} % of its last move is a band of width 0: set band"
    of_move = f" ({p.percent:g} % of the last move)" if half_width > p.band else ""
    return f"the error is outside ±{half_width:g}{of_move} at the end of the run"


@metric(SettlingParams(), SettlingState(), output=settled, unit="s", no_value=no_settling)
def settling_time(p, s, command, error, t):
    """Time from the last change of the command to the first sample after which ``|error|`` stays inside the band.

    The half width of the band is the larger of ``band`` and ``percent`` of the last move, which goes from the command
    before it (at the first sample: from ``actual``) to the command after it. NaN where the error is outside, or the
    command still changes, at the end. For a band in units alone: ``settling_time(percent=0.0, band=0.001)``. Without a
    move, time counts from 0.
    """
    before = s.last_command if s.seen > 0.0 else command - error
    changed = command != before
    origin = before if changed and s.moving == 0.0 else s.origin if s.seen > 0.0 else command
    half_width = max(p.band, 0.01 * p.percent * abs(command - origin))
    inside = abs(error) <= half_width
    stays = inside and s.inside > 0.0 and not changed
    return SettlingState(
        t if changed else s.start,
        s.entered if stays else t,
        1.0 if inside else 0.0,
        origin,
        command,
        1.0 if changed else 0.0,
        1.0,
    )


STANDARD: dict[str, Block] = {
    "rms_error": rms_error,
    "max_error": max_error,
    "iae": iae,
    "ise": ise,
    "itae": itae,
    "overshoot": overshoot,
    "rise_time": rise_time,
    "settling_time": settling_time,
    "steady_state_error": steady_state_error,
    "effort": effort,
    "chatter": chatter,
    "zero_crossing_rate": zero_crossing_rate,
}
"""The metrics that every run gets."""
