"""A log of torque and position: checked, and what slides and what sticks in it.

In sliding the momentum over a window of ``W`` samples is a straight line in what is sought,

    mean T = F_C sign(v) + sigma_2 mean v + J (v_end - v_start) / (W dt) + offset

with ``T`` held from each sample to the next (linear least squares; where neighbouring windows overlap, the standard
errors say so). Around every standstill lies a *piece* for the replay.

A piece of a log played back: the logged torque on a model of the stage that follows the logged position.

    T_model = T_logged + kp (y_log - y_model)

``kp`` is a thousandth of the bristles' stiffness and keeps the model beside the log where the axis slides: there an
error of the torque would be integrated twice. ``y_log`` must be smooth: the steps of a reading would shake the
bristles, and bristles near their limit creep when shaken. Nothing is asked of the controller that made the log.

Coarse integration may step over the limit of bristles that barely hold, to a slip that is none: ``rtol`` 1e-4 does not,
1e-3 does.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from leadscrew.friction.lugre import LuGre, friction, steady_bristle
from leadscrew.identify.axis.record import count_of
from leadscrew.identify.estimation import identifiable, quantile, white
from leadscrew.identify.log_player import row_at
from leadscrew.kernel.block import controller, plant, reference
from leadscrew.kernel.loop import Loop
from leadscrew.kernel.parameters import Doc, Gt, Unit
from leadscrew.plants._ballscrew_stage import INERTIA, BallscrewStageState, stage_jacobian, stage_level
from leadscrew.util.errors import DataError

SLIDES = 0.05
"""Share of the highest speed above which the axis surely slides, far above any Stribeck speed."""
NEARLY = 0.012
"""Share below which a piece begins."""
CREEPS = 0.004
"""Share below which a piece that began at rest goes on: above it has slipped."""
STEADY = 0.002
"""Change of the speed from one window to the next, differenced once more, above which a window rings."""
OUTLIERS, ROUNDS = 4.0, 4
"""Windows that the line misses by more than so many standard deviations are left out, found so many times over."""
WINDOW_S, SPEED_S = 0.01, 0.002
"""Window of a momentum balance, and half of what a speed at its ends is taken over."""
HURRY = 6.0
"""Change of the torque at a stand-still, in Coulomb frictions per second, above which its instant matters too much."""
CAME_S = 0.02
"""The way that an axis came to a stand-still is that of its travel over this time: a slip may rebound."""
LEAST_S = 0.2
"""Sliding time in each direction that a straight line is fitted to."""
MOST = 200_000
"""Samples of a log; 50 s at 4 kHz."""


class Piece(NamedTuple):
    """From a stand-still or shortly before it, until the axis slips or slides again."""

    first: int
    length: int
    start_torque: float
    start_speed: float
    """0: begins at rest."""
    start_angle: float


@dataclass(frozen=True)
class Sliding:
    """Friction in sliding, by linear least squares."""

    coulomb: float
    viscous: float
    inertia: float
    offset: float
    """Torque that does not turn with the direction: weight, or friction that differs by direction."""
    standard_error: dict[str, float]
    rms_torque: float
    """Of what the line leaves."""
    windows: int
    top_speed: float


@dataclass(frozen=True)
class Record:
    """An evenly sampled log in rad and N m (or m and N)."""

    period: float
    torque: np.ndarray
    angle: np.ndarray
    count: float
    """Smallest change of the position: the encoder's step."""
    noise: float
    """Of the position, root mean square; not below what rounding to counts makes."""


def checked(time_s: np.ndarray, torque: np.ndarray, angle: np.ndarray, delay: int = 0) -> Record:
    """The log, or a refusal in one sentence; ``delay``: periods from a logged torque to its act.

    Raises:
        DataError: unequal lengths, too few or too many samples, a value that is not finite, times that do not rise
            evenly, a torque or position that never changes.
    """
    t, u, y = (np.asarray(part, dtype=np.float64) for part in (time_s, torque, angle))
    if t.ndim != 1 or not t.shape == u.shape == y.shape:
        raise DataError(f"time, torque and position have {t.size}, {u.size} and {y.size} samples; expected equal ones")
    for name, values in (("time", t), ("torque", u), ("position", y)):
        bad = np.flatnonzero(~np.isfinite(values))
        if len(bad):
            raise DataError(f"{name}: sample {bad[0] + 1} is {values[bad[0]]}, not a finite number")
    if not 0 <= delay < 100 or delay != int(delay):
        raise DataError(f"delay = {delay!r}: expected a whole number of periods from 0 to 99")
    if t.size < 500 or t.size > MOST:
        raise DataError(f"the log has {t.size} samples; allowed are 500 to {MOST} (a record of about 8 s serves best)")
    steps = np.diff(t)
    period = float((t[-1] - t[0]) / (t.size - 1))
    if not period > 0.0 or np.max(np.abs(steps - period)) > 0.01 * period:
        at = int(np.argmax(np.abs(steps - period)))
        raise DataError(
            f"time: from sample {at + 1} to {at + 2} pass {steps[at]:g} s where the mean is {period:g} s; "
            "expected even sampling without gaps"
        )
    if period > 2e-3:
        raise DataError(f"time: a sample every {period:g} s; bristles need one every 0.002 s or faster")
    for name, values in (("torque", u), ("position", y)):
        if np.ptp(values) <= 1e-12 * max(1.0, float(np.max(np.abs(values)))):
            raise DataError(f"{name} is the same, {values[0]:g}, in all samples: nothing was excited")
    if delay:
        u, y = u[: -int(delay)], y[int(delay) :]
    count = count_of(y)
    wobble, way = np.abs(y[2:] - 2.0 * y[1:-1] + y[:-2]), np.abs(y[2:] - y[:-2])
    still = wobble[way <= max(2.5 * count, float(np.quantile(way, 0.2)))]
    still = still[still <= np.quantile(still, 0.99)]
    noise = max(float(np.sqrt(np.mean(still**2) / 6.0)), count / np.sqrt(12.0))
    return Record(period, u, y, count, noise)


def sliding(record: Record) -> Sliding:
    """The line through all that slides.

    Raises:
        DataError: the axis does not slide in both directions for long enough, or slides at one speed only, or torque
            and motion do not belong together (columns swapped, a sign turned).
    """
    dt, y, u = record.period, record.angle, record.torque
    window, half = max(4, round(WINDOW_S / dt)), max(1, round(SPEED_S / dt))
    starts = np.arange(half, len(y) - window - half, max(1, window // 2))
    total = np.concatenate([[0.0], np.cumsum(u)])
    begin = (y[starts + half] - y[starts - half]) / (2 * half * dt)
    end = (y[starts + window + half] - y[starts + window - half]) / (2 * half * dt)
    mean = (y[starts + window] - y[starts]) / (window * dt)
    torque = (total[starts + window] - total[starts]) / window
    top = float(np.max(np.abs(mean)))
    low = np.minimum(np.abs(begin), np.abs(end))
    going = (low > SLIDES * top) & (np.sign(begin) == np.sign(end)) & (np.sign(begin) == np.sign(mean))
    # What has just begun to slide, or is about to stop, still rings.
    going &= _all_around(going, 2) & (np.abs(np.gradient(end - begin)) < STEADY * top)
    per_way = [0.5 * window * dt * float(np.sum(going & (np.sign(mean) == way))) for way in (1.0, -1.0)]
    if min(per_way) < LEAST_S:
        raise DataError(
            f"the log slides {per_way[0]:.2g} s forwards and {per_way[1]:.2g} s backwards; at least {LEAST_S:g} s each "
            "way are needed: let the axis reverse"
        )
    driven = float(np.mean(np.sign(torque[going]) == np.sign(mean[going])))
    if driven < 0.8:
        raise DataError(
            f"torque and motion point the same way in {100.0 * driven:.0f} % of the sliding; friction asks for nearly "
            "all of it: are the columns of torque and position swapped, or has one the other sign?"
        )
    a = np.column_stack([np.sign(mean), mean, (end - begin) / (window * dt), np.ones_like(mean)])[going]
    b = torque[going]
    for _ in range(ROUNDS):
        x, *_ = np.linalg.lstsq(a, b, rcond=None)
        left = b - a @ x
        middling = np.abs(left) <= OUTLIERS * 1.4826 * float(np.median(np.abs(left)))
        a, b, left = a[middling], b[middling], left[middling]
    rms = float(np.sqrt(np.mean(left * left)))
    # Neighbours overlap by half: every second window is new.
    spread = np.sqrt(2.0 * np.diag(white(a, left).covariance))
    names = ("coulomb", "viscous", "inertia", "offset")
    error = dict(zip(names, spread.tolist(), strict=True))
    if not x[0] > 0.0 or not identifiable(x[0], quantile() * error["coulomb"]):
        raise DataError(
            f"Coulomb friction from the sliding is {x[0]:.3g} with a standard error of {error['coulomb']:.2g}: the log "
            "slides at too few speeds, or its torque is not that of the axis"
        )
    coulomb, viscous, inertia, offset = x.tolist()
    return Sliding(coulomb, viscous, inertia, offset, error, rms, len(b), top)


def pieces(record: Record, slide: Sliding) -> list[Piece]:
    """What the bristles can be seen in: around every standstill of the log.

    Where the torque changes slowly and nothing accelerates a piece begins at rest, in the middle of the stand-still:
    there the bristles hold the torque. Elsewhere it begins while the axis still slides.
    """
    dt, y, u = record.period, record.angle, record.torque
    quick, calm = (_speed(y, max(2, round(s / dt)), dt) for s in (0.001, 0.005))
    near = np.abs(quick) < NEARLY * slide.top_speed
    edges = np.diff(np.concatenate([[0], near.astype(np.int8), [0]]))
    found, back = [], round(CAME_S / dt)
    for i, j in zip(np.flatnonzero(edges == 1).tolist(), np.flatnonzero(edges == -1).tolist(), strict=True):
        came = float(np.sign(y[i] - y[max(0, i - back)]))
        # the middle of all that reads as the turning point: at a count's edge the reading flickers
        turn = np.flatnonzero(came * y[i:j] >= np.max(came * y[i:j]) - 0.5 * record.count)
        rest = i + (int(turn[0] + turn[-1]) // 2 if came else 0)
        side = min(round(SPEED_S / dt), rest, len(y) - 1 - rest)
        change = abs(float(u[rest + side] - u[rest - side])) / (2 * max(side, 1) * dt)
        bend = abs(float(y[rest + side] - 2.0 * y[rest] + y[rest - side])) / (max(side, 1) * dt) ** 2
        if change < HURRY * slide.coulomb and slide.inertia * bend < 0.002 * slide.coulomb:
            over = np.flatnonzero(np.abs(calm[rest:]) > CREEPS * slide.top_speed)
            last = rest + (int(over[0]) if len(over) else len(y) - rest)
            found.append(Piece(rest, last - rest, float(u[rest]), 0.0, float(y[rest])))
        else:
            piece = _moving(record, slide, i, quick)
            found += [piece] if piece else []
    need = 0.5 * slide.coulomb
    long_enough = [p for p in found if p.length >= 20 and np.ptp(u[p.first : p.first + p.length]) > need]
    kept: list[Piece] = []
    for piece in long_enough:
        if not kept or piece.first >= kept[-1].first + kept[-1].length // 2:
            kept.append(piece)
    return kept


def _moving(record: Record, slide: Sliding, first: int, quick: np.ndarray) -> Piece | None:
    """A piece that begins while the axis slides towards a reversal."""
    dt, y, u = record.period, record.angle, record.torque
    side = max(4, round(0.003 / dt))
    first -= side
    before = round(WINDOW_S / dt)
    # a slip is no sliding: where it began the bristles are not known
    if first < before or np.min(np.abs(quick[first - before : first])) < NEARLY * slide.top_speed:
        return None
    around = np.arange(-side, side + 1)
    _, speed, angle = np.polyfit(around * dt, y[first - side : first + side + 1], 2)
    begins = first + 2 * side
    fast = np.flatnonzero(np.abs(quick[begins:]) > SLIDES * slide.top_speed)
    last = begins + int(fast[0]) if len(fast) else len(y)
    length = min(last - first, round(0.1 / dt))
    return Piece(first, length, float(u[first]), float(speed), float(angle)) if speed != 0.0 else None


def _all_around(flags: np.ndarray, side: int) -> np.ndarray:
    around = np.lib.stride_tricks.sliding_window_view(np.pad(flags, side), 2 * side + 1)
    return np.asarray(around.all(axis=1))


def _speed(y: np.ndarray, side: int, dt: float) -> np.ndarray:
    speed = np.empty(len(y))
    speed[side:-side] = (y[2 * side :] - y[: -2 * side]) / (2 * side * dt)
    speed[:side], speed[-side:] = speed[side], speed[-side - 1]
    return speed


BANDWIDTH = 300.0
"""rad/s, ``sqrt(kp / J)``; a fifth of the sampling rate at most."""


class Logged(NamedTuple):
    """One sample."""

    torque: float = 0.0
    angle: float = 0.0


class PieceParams(NamedTuple):
    """The log, and which piece of it."""

    first: Annotated[float, Doc("sample that the piece starts at")] = 0.0
    length: Annotated[float, Doc("samples of the piece; the last is held from then on")] = 1.0
    torque: Annotated[NDArray[np.float64], Unit("N m"), Doc("held from each sample to the next")] = np.zeros(1)
    angle: Annotated[NDArray[np.float64], Unit("rad"), Doc("at each sample, smooth")] = np.zeros(1)


def piece_step(p, t, dt):
    """The sample at ``t``."""
    row = int(min(row_at(p.first, t, dt), p.first + p.length - 1.0))
    return Logged(p.torque[row], p.angle[row])


class FollowParams(NamedTuple):
    """How the model is kept beside the log."""

    kp: Annotated[float, Unit("N m/rad"), Doc("torque per error")] = 33.0


class FollowState(NamedTuple):
    """The error."""

    e: Annotated[float, Unit("rad"), Doc("logged minus modelled angle")] = 0.0


@controller(FollowParams(), FollowState(), unit="N m")
def follow(p, s, command, feedback, dt):
    """The logged torque, plus what keeps the model beside the log."""
    e = command.angle - feedback
    return FollowState(e), command.torque + p.kp * e


class ReplayParams(NamedTuple):
    """The stage, and how it moves when the piece starts."""

    inertia: Annotated[float, Unit("kg m^2"), Gt(0)] = INERTIA
    start_torque: Annotated[float, Unit("N m"), Doc("what the bristles hold, where it starts at rest")] = 0.0
    start_speed: Annotated[float, Unit("rad/s"), Doc("0: at rest")] = 0.0
    start_angle: Annotated[float, Unit("rad")] = 0.0
    friction: LuGre = LuGre()


def replay_start(p):
    """At rest the bristles hold the torque; in motion they slide steadily."""
    held = p.start_torque / p.friction.stiffness
    bristle = steady_bristle(p.friction, p.start_speed) if p.start_speed != 0.0 else held
    return BallscrewStageState(p.start_angle, p.start_speed, bristle)


@plant(ReplayParams(), BallscrewStageState(), initial=replay_start, output="angle", jacobian=stage_jacobian, stiff=True)
def replayed_stage(p, s, u, load):
    """The ball-screw stage with a start of its own."""
    f = p.friction
    rate = s.speed - abs(s.speed) * s.bristle * f.stiffness / stage_level(f, s.speed)
    torque = u + load - friction(f, s.speed, s.bristle, rate)
    return BallscrewStageState(s.speed, torque / p.inertia, rate)


def replay_loop(torque: np.ndarray, angle: np.ndarray, period: float, inertia: float) -> Loop:
    """The loop that plays pieces back; its error is ``controller.e``."""
    pace = min(BANDWIDTH, 0.2 / period)
    log = PieceParams(torque=np.ascontiguousarray(torque), angle=np.ascontiguousarray(angle))
    return Loop(
        reference=reference(log, name="piece")(piece_step),
        controller=follow(kp=inertia * pace * pace),
        plant=replayed_stage(inertia=inertia),
        period=period,
        metrics={},
        method="rodas",
        rtol=1e-4,
        atol=1e-8,
        name="replay of a log",
    )
