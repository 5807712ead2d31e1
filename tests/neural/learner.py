"""A network that learns what another one says: the Kalman filter of the controllers alone in a compiled loop."""

import math
from typing import NamedTuple

import numpy as np

from leadscrew import Loop
from leadscrew.fuzzy.inference import Axis
from leadscrew.kernel.block import controller, plant
from leadscrew.neural.inference_net import AXIS, W0, fired, network_output
from leadscrew.neural.kalman import kalman_learn
from leadscrew.references._step import step


class LearnerParams(NamedTuple):
    """E and EC up to ``inside`` levels; ``error``: amplitude of what is wrong with the target, levels."""

    axis: Axis = AXIS
    teacher: np.ndarray = W0
    inside: float = 2.0
    error: float = 0.1
    r: float = 1e-4
    q: float = 0.0
    cap: float = 1e300


class LearnerState(NamedTuple):
    """The network, and where it is asked."""

    weights: np.ndarray = np.zeros(49)
    covariance: np.ndarray = 1e4 * np.eye(49)
    first: float = 0.0
    second: float = 0.0


@controller(LearnerParams(), LearnerState())
def learner(p, s, command, feedback):
    """One Kalman update a period, at points that fill the square evenly (multiples of two irrational numbers)."""
    first = s.first + 0.7548776662466927
    second = s.second + 0.5698402909980532
    first = first - math.floor(first)
    second = second - math.floor(second)
    at = fired(p.axis, p.axis, p.inside * (2.0 * first - 1.0), p.inside * (2.0 * second - 1.0))
    off = p.error * math.sin(50.0 * first)
    answer = network_output(s.weights, at)
    kalman_learn(s.weights, s.covariance, at, network_output(p.teacher, at) + off - answer, p.r, p.q, p.cap, 6.0)
    return LearnerState(s.weights, s.covariance, first, second), answer


class Nothing(NamedTuple):
    """A plant that stands still."""

    x: float = 0.0


@plant(None, Nothing())
def still(s, u, dt):
    """Nothing."""
    return Nothing(0.0 * u)


def learner_loop(**values: float) -> Loop:
    """A period is an update."""
    return Loop(
        reference=step(target=0.0), controller=learner(**values), plant=still, metrics={}, period=0.01, name="learner"
    )


def state(live):
    """State of the learner as it is now; a copy."""
    return live.program.plan.state.unpack(live.state[0].copy(), live.state[1].copy()).controller


def learned(updates: int = 20000, **values: float) -> np.ndarray:
    """Its covariance after some updates."""
    live = learner_loop(**values).start()
    live.advance(updates, every=0)
    return np.asarray(state(live).covariance)
