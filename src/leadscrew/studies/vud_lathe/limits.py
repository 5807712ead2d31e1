"""The axis with limits: bounds of the time that a step takes, and what the PWM timer does to a controller's rest."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from leadscrew.analysis.single_lag import single_lag_time
from leadscrew.analysis.time_optimal import FastestMove, StateLimit, fastest_move, least_error
from leadscrew.kernel.block import Block
from leadscrew.plants._lathe_servo_limited import LatheLimitedParams, chain_matrices, lathe_servo_limited
from leadscrew.studies.lab import Lab, measure
from leadscrew.studies.vud_lathe.controllers import CONTROLLERS
from leadscrew.studies.vud_lathe.scenarios import MACHINES, ON_THE_ENCODER, PERIOD_S, PRINTED_SECONDS

if TYPE_CHECKING:
    from leadscrew.kernel.run import Run

BAND_MM = 0.002
AXIS = LatheLimitedParams()
AXIS_LAGS_S = AXIS.pwm_lag_s + AXIS.electrical_lag_s + AXIS.mechanical_lag_s
UNLIMITED = {"current_limit_a": 1e9, "top_speed_mm_s": 1e9}
SAMPLED_ONLY_MM_S = 0.05
"""The played sequence keeps so far below the top speed: the programme sees the speed once a period, the axis always."""
REST_PERIODS = 10
"""The played sequence is at rest so soon; the bound leaves more time, which does not make it shorter."""
TRIED = (
    "paper.vud",
    "corrected.vud_beta_e",
    "corrected.vud_beta_e_half",
    "ours.original_fit",
    "ours.pd",
    "ours.vud_opt",
    "ours.vud_fast",
    "ours.vud_fast_limited",
)
"""Controllers whose settling is judged on the limited machine too."""


def tried_on(lab: Lab, controller: str, scenario: str, machine: str) -> Run:
    """The run of a controller on the linear or on the limited machine, long enough for the printed law to arrive."""
    seconds = PRINTED_SECONDS if controller == "paper.vud" else None
    options = {} if machine == "linear" else {"machine": machine}
    return lab.run(controller, scenario, seconds, **options)


@measure
def with_timer(lab: Lab, controller: str, scenario: str, key: str, value: float) -> Run:
    """A run on the limited machine with one parameter of its PWM timer changed: ``carry``, ``minimum_on_counts``."""
    return lab.loop(controller, scenario, machine="limited").using({f"actuator.{key}": value}).run(4.0)


def one_lag_s(distance: float, top_speed: float = math.inf) -> float:
    """Least time with the lags (2), (3) added up to one."""
    return single_lag_time(distance, AXIS.full_duty_speed_mm_s, AXIS_LAGS_S, top_speed)


def _limits(spare: float) -> tuple[StateLimit, ...]:
    """Current and speed, the states 1 and 2 of the chain."""
    return (StateLimit(1, AXIS.current_limit_a), StateLimit(2, AXIS.top_speed_mm_s - spare))


@measure
def bound(lab: Lab, distance: float, limited: bool) -> FastestMove:
    """The fewest periods to within 2 um, with the linear chain or inside the limits of current and speed."""
    a, b = chain_matrices(AXIS)
    limits = _limits(0.0) if limited else ()
    near = one_lag_s(distance, AXIS.top_speed_mm_s if limited else math.inf)
    return fastest_move(a[:4, :4], b[:4], np.identity(4)[3], distance, BAND_MM, PERIOD_S, limits, near)


def _ready(block: Block, dt: float) -> Any:
    return block.prepare(block.params, dt) if block.prepare else block.params


class Played(NamedTuple):
    """The fastest move, done by the plant: one value at the start of every period."""

    time: np.ndarray
    error_um: np.ndarray
    speed: np.ndarray
    current: np.ndarray


@measure
def played(lab: Lab, distance: float, limited: bool, seconds: float = 1.0) -> Played:
    """The duties of :func:`bound` on the plant itself, limits acting between the samples as well."""
    a, b = chain_matrices(AXIS)
    limits = _limits(SAMPLED_ONLY_MM_S) if limited else ()
    periods = bound(lab, distance, limited).periods
    _, duty = least_error(a[:4, :4], b[:4], np.identity(4)[3], distance, periods, PERIOD_S, limits, REST_PERIODS)
    block = lathe_servo_limited if limited else lathe_servo_limited(**UNLIMITED)
    p, s = _ready(block, PERIOD_S), block.state
    rows = []
    for k in range(round(seconds / PERIOD_S)):
        rows.append((distance - s.position, s.speed, s.current))
        s = block.step(p, s, -duty[k] if k < len(duty) else 0.0, PERIOD_S)
    error, speed, current = np.array(rows).T
    return Played(PERIOD_S * np.arange(len(rows)), 1000.0 * error, speed, current)


def standing_um(controller: str, least_duty: float) -> float:
    """The largest error, in whole counts of its sensor, at which a resting law asks for less than ``least_duty``.

    0 where one count of error asks for more.
    """
    block: Block = CONTROLLERS[controller]
    sensor = MACHINES["limited"].encoder if block.name in ON_THE_ENCODER else MACHINES["limited"].grating
    count_mm = float(sensor.params.resolution_mm)
    p = _ready(block, PERIOD_S)
    quiet = 0
    for count in range(1, 1600):
        state, output = block.state, 0.0
        for _ in range(50):
            if state is None:
                output = block.step(p, 0.0, count * count_mm, *_dt(block))
            else:
                state, output = block.step(p, state, 0.0, count * count_mm, *_dt(block))
        if abs(output) >= least_duty:
            break
        quiet = count
    return 1000.0 * count_mm * quiet


def _dt(block: Block) -> tuple[float, ...]:
    return (PERIOD_S,) if "dt" in block.signals else ()
