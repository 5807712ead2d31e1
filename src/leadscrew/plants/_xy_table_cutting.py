"""The axis of the XY table with its dead time, under the forces of a milling spindle; exact at any period.

    x' = A x + b (gain u(t - dead_time) + load_gain (load + d(t))),      y = x_1,      equation (1) as in ``xy_table``
    d(t) = spindle_v sin(w t + spindle_phase) + tooth_v sin(teeth w t + tooth_phase),      w = 2 pi spindle_hz

``u`` is held from ``dead_time_s`` after each sample until ``dead_time_s`` after the next; the dead time is a parameter
of any length, not a multiple of anything. With ``dead_time = n T + theta`` and ``Gamma(h)`` the response to an input of
one held over ``h``:

    x_(k+1) = e^(A T) x_k + e^(A (T - theta)) Gamma(theta) u_(k-n-1) + Gamma(T - theta) u_(k-n) + Gamma(T) load_k
              + p(t_k + T) - e^(A T) p(t_k),      p(t) = Im[(j w I - A)^-1 b e^(j (w t + phase))] for each line

each times its gain. Nothing is approximated: the lines are not held over a period, so a tooth-passing frequency above
half the sampling frequency acts as it does on a machine, and folds where the encoder is read. ``load`` is held; it acts
without delay. ``load_gain`` is apart from ``gain`` so that a drive whose gain is off does not change the forces.

Source: equation (1) of Abdullah et al. (see :obj:`leadscrew.plants.xy_table`). The paper gives neither dead time nor
cutting force. 0.775 ms at 2 kHz is what its stability plot needs; the lines (1 mV of runout, 2 mV at the teeth of a
two-flute cutter) are ours.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Annotated, Any, NamedTuple

import numpy as np

from leadscrew.kernel.block import plant
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit
from leadscrew.plants._linear import hold_matrices
from leadscrew.util.errors import ValueRefused

MOST_PERIODS = 4
"""Longest dead time, in periods."""

TWO_PI = 2.0 * math.pi


class XYTableCuttingParams(NamedTuple):
    """Equation (1), its dead time, and the spindle."""

    gain: Annotated[float, Unit("mm/(V s^2)"), Gt(0), Doc("numerator: acceleration at 1 V from rest, (1)")] = 69380.0
    damping: Annotated[float, Unit("1/s"), Ge(0), Doc("denominator, coefficient of s, (1)")] = 144.8
    stiffness: Annotated[float, Unit("1/s^2"), Ge(0), Doc("denominator, constant coefficient, (1)")] = 166.3
    dead_time_s: Annotated[float, Unit("s"), Ge(0), Doc("from the sample to the voltage, at most 4 periods")] = 0.775e-3
    load_gain: Annotated[
        float,
        Unit("mm/(V s^2)"),
        Gt(0),
        Doc("acceleration at 1 V of load or force line: not the drive's, if that is off"),
    ] = 69380.0
    spindle_hz: Annotated[float, Unit("Hz"), Ge(0), Le(1e5), Doc("revolutions a second; 0: at rest")] = 0.0
    spindle_v: Annotated[float, Unit("V"), Doc("force line once a revolution, as a voltage at the input")] = 0.0
    spindle_phase: Annotated[float, Unit("rad"), Doc("its angle at t = 0")] = 0.0
    teeth: Annotated[int, Ge(1), Le(100), Doc("teeth of the cutter")] = 2
    tooth_v: Annotated[float, Unit("V"), Doc("force line once a tooth, as a voltage at the input")] = 0.0
    tooth_phase: Annotated[float, Unit("rad"), Doc("its angle at t = 0")] = 0.0


class XYTableCuttingState(NamedTuple):
    """Motion, and the voltages that have not acted yet."""

    position: Annotated[float, Unit("mm")] = 0.0
    velocity: Annotated[float, Unit("mm/s")] = 0.0
    sent: Annotated[float, Unit("V"), Doc("voltage of the last period")] = 0.0
    sent2: Annotated[float, Unit("V"), Doc("of the one before")] = 0.0
    sent3: Annotated[float, Unit("V"), Doc("and before")] = 0.0
    sent4: Annotated[float, Unit("V"), Doc("and before")] = 0.0
    sent5: Annotated[float, Unit("V"), Doc("and before")] = 0.0


class Response(NamedTuple):
    """What something adds to position and velocity over one period."""

    position: float
    velocity: float


class LineResponse(NamedTuple):
    """What a sinusoidal force adds over one period, times sine and cosine of its angle at the sample."""

    rate: float
    """rad/s."""
    sine: Response
    cosine: Response


class XYTableCuttingHold(NamedTuple):
    """The exact step over one period."""

    from_position: Response
    from_velocity: Response
    load: Response
    now: Response
    sent: Response
    sent2: Response
    sent3: Response
    sent4: Response
    sent5: Response
    spindle: LineResponse
    tooth: LineResponse


def hold(params: XYTableCuttingParams, dt: float) -> XYTableCuttingHold:
    """The exact step.

    Raises:
        ValueRefused: a dead time of more than four periods.
    """
    late = params.dead_time_s / dt
    if late > MOST_PERIODS:
        raise ValueRefused(
            f"dead_time_s = {params.dead_time_s!r} (xy_table_cutting): at most {MOST_PERIODS} periods, here "
            f"{MOST_PERIODS * dt:g} s"
        )
    whole = math.floor(late + 1e-9)
    theta = max(params.dead_time_s - whole * dt, 0.0)
    theta = theta if theta > 1e-9 * dt else 0.0
    shape = (params.damping, params.stiffness)
    transition, all_of_it = _hold(dt, *shape)
    late_transition, first = _hold(dt - theta, *shape)
    drive = np.zeros((MOST_PERIODS + 2, 2))
    drive[whole] += first
    if theta > 0.0:
        drive[whole + 1] += late_transition @ _hold(theta, *shape)[1]
    rows: list[Any] = [Response(*(params.gain * row).tolist()) for row in drive]
    a = np.array([[0.0, 1.0], [-params.stiffness, -params.damping]])
    rate = TWO_PI * params.spindle_hz
    lines: list[Any] = [
        _line(a, transition, params.load_gain * size, phase, w, dt)
        for size, phase, w in (
            (params.spindle_v, params.spindle_phase, rate),
            (params.tooth_v, params.tooth_phase, params.teeth * rate),
        )
    ]
    from_position, from_velocity = (Response(*column.tolist()) for column in transition.T)
    load = Response(*(params.load_gain * all_of_it).tolist())
    return XYTableCuttingHold(from_position, from_velocity, load, *rows, *lines)


@lru_cache(maxsize=1024)
def _hold(dt: float, damping: float, stiffness: float) -> tuple[np.ndarray, np.ndarray]:
    return hold_matrices(np.array([[0.0, 1.0], [-stiffness, -damping]]), np.array([0.0, 1.0]), dt)


def _line(a: np.ndarray, transition: np.ndarray, size: float, phase: float, rate: float, dt: float) -> LineResponse:
    if rate == 0.0 or size == 0.0:
        return LineResponse(0.0, Response(0.0, 0.0), Response(0.0, 0.0))
    steady = np.linalg.solve(1j * rate * np.eye(2) - a, np.array([0.0, size * np.exp(1j * phase)]))
    added = (np.exp(1j * rate * dt) * np.eye(2) - transition) @ steady
    return LineResponse(rate, Response(*added.real.tolist()), Response(*added.imag.tolist()))


@plant(XYTableCuttingParams, XYTableCuttingState, output="position", prepare=hold, unit="mm", drive="voltage")
def xy_table_cutting(p, s, u, load, t, dt):
    """Axis of the XY table with dead time, spindle line and tooth-passing line: state one period later."""
    s1, c1 = math.sin(p.spindle.rate * t), math.cos(p.spindle.rate * t)
    s2, c2 = math.sin(p.tooth.rate * t), math.cos(p.tooth.rate * t)
    force = Response(
        p.spindle.sine.position * s1 + p.spindle.cosine.position * c1
        + p.tooth.sine.position * s2 + p.tooth.cosine.position * c2,
        p.spindle.sine.velocity * s1 + p.spindle.cosine.velocity * c1
        + p.tooth.sine.velocity * s2 + p.tooth.cosine.velocity * c2,
    )  # fmt: skip
    position = p.from_position.position * s.position + p.from_velocity.position * s.velocity
    velocity = p.from_position.velocity * s.position + p.from_velocity.velocity * s.velocity
    driven = Response(
        p.now.position * u + p.sent.position * s.sent + p.sent2.position * s.sent2 + p.sent3.position * s.sent3
        + p.sent4.position * s.sent4 + p.sent5.position * s.sent5,
        p.now.velocity * u + p.sent.velocity * s.sent + p.sent2.velocity * s.sent2 + p.sent3.velocity * s.sent3
        + p.sent4.velocity * s.sent4 + p.sent5.velocity * s.sent5,
    )  # fmt: skip
    return XYTableCuttingState(
        position + driven.position + force.position + p.load.position * load,
        velocity + driven.velocity + force.velocity + p.load.velocity * load,
        u, s.sent, s.sent2, s.sent3, s.sent4,
    )  # fmt: skip
