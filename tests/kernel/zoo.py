"""Small blocks that between them use everything that a step may use."""

import math
from typing import Annotated, NamedTuple

import numpy as np

from leadscrew.kernel.block import actuator, controller, disturbance, plant, reference, sensor
from leadscrew.kernel.noise import normal
from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit

GRAVITY = 9.81


class SineParams(NamedTuple):
    amplitude: Annotated[float, Unit("mm"), Ge(0), Doc("Peak.")] = 1.0
    frequency: Annotated[float, Unit("Hz"), Gt(0), Doc("Frequency.")] = 0.7


@reference(SineParams(), unit="mm")
def sine(p, t):
    """A sine."""
    return p.amplitude * math.sin(2 * math.pi * p.frequency * t)


class PIDParams(NamedTuple):
    kp: Annotated[float, Unit("V/mm"), Ge(0), Doc("Proportional gain.")] = 1.32
    ki: Annotated[float, Unit("V/(mm s)"), Ge(0)] = 0.05
    kd: Annotated[float, Unit("V s/mm"), Ge(0)] = 0.006805


class PIDState(NamedTuple):
    integral: float = 0.0
    last_error: float = 0.0


def pid_align(p, command, feedback, output):
    """State under which the output continues where it was."""
    error = command - feedback
    return PIDState((output - p.kp * error) / p.ki if p.ki > 0 else 0.0, error)


@controller(PIDParams(), PIDState(), align=pid_align)
def pid(p, s, command, feedback, dt):
    """A parallel PID."""
    error = command - feedback
    integral = s.integral + error * dt
    output = p.kp * error + p.ki * integral + p.kd * (error - s.last_error) / dt
    return PIDState(integral, error), output


class MassParams(NamedTuple):
    mass: Annotated[float, Unit("kg"), Gt(0)] = 1.0
    damping: Annotated[float, Unit("N s/m"), Ge(0)] = 10.0
    gain: float = 100.0


class MassState(NamedTuple):
    position: float = 0.0
    velocity: float = 0.0


@plant(MassParams(), MassState())
def mass(p, s, u):
    """A damped mass."""
    return MassState(s.velocity, (p.gain * u - p.damping * s.velocity) / p.mass)


@plant(MassParams(), MassState(), output="position")
def loaded_mass(p, s, u, load, t):
    """A damped mass that takes its load itself and feels time."""
    return MassState(s.velocity, (p.gain * u + load - (p.damping + 0.1 * math.cos(t)) * s.velocity) / p.mass)


class Measured(NamedTuple):
    position: float
    velocity: float


def both(p, s):
    """Position and momentum's velocity."""
    return Measured(s.position, s.velocity / p.mass * p.mass)


@plant(MassParams(), MassState(), output=both)
def shown_mass(p, s, u):
    """A damped mass that shows position and velocity."""
    return MassState(s.velocity, (p.gain * u - p.damping * s.velocity) / p.mass)


class RulerParams(NamedTuple):
    resolution: Annotated[float, Unit("mm"), Gt(0)] = 0.001
    deviation: Annotated[float, Unit("mm"), Ge(0)] = 0.0005


@sensor(RulerParams())
def ruler(p, actual, noise):
    """A noisy quantiser."""
    return math.floor((actual + p.deviation * normal(noise, 0)) / p.resolution + 0.5) * p.resolution


class HistoryParams(NamedTuple):
    weights: np.ndarray = np.array([0.4, 0.3, 0.2, 0.1])
    gain: float = 1.2
    taps: int = 4


class HistoryState(NamedTuple):
    past: np.ndarray = np.zeros(4)
    at: int = 0
    sharp: bool = False


@controller(HistoryParams(), HistoryState())
def history(p, s, command, feedback):
    """A filtered P controller with its past in a ring: arrays, integers, a loop, a branch."""
    s.past[s.at] = command - feedback
    total = 0.0
    for i in range(len(p.weights)):
        total += p.weights[i] * s.past[(s.at - i) % p.taps]
    sharp = abs(total) > 0.2
    if sharp:
        total = total * 1.1
    elif total > 0.1:
        total **= 3
        total = 10 * total
    return HistoryState(s.past, (s.at + 1) % p.taps, sharp), p.gain * total


class LimitParams(NamedTuple):
    most: Annotated[float, Gt(0)] = 0.5
    rate: Annotated[float, Gt(0)] = 50.0


class LimitState(NamedTuple):
    last: float = 0.0


@actuator(LimitParams(), LimitState())
def limits(p, s, output, dt):
    """Saturation and rate limit."""
    step = p.rate * dt
    u = min(max(output, s.last - step, -p.most), s.last + step, p.most)
    return LimitState(u), u


class PushParams(NamedTuple):
    size: float = 5.0


@disturbance(PushParams())
def push(p, t, noise):
    """A push with noise."""
    return p.size * (t > 0.1) + 0.1 * normal(noise, 1)


class DriftState(NamedTuple):
    x: float = 0.0


@disturbance(None, DriftState())
def drift(s, dt):
    """A slow drift of the true output."""
    return DriftState(s.x + 0.01 * dt), s.x


# ---- two axes, cascade, every n-th period
class Two(NamedTuple):
    x: float
    y: float


class CircleParams(NamedTuple):
    radius: float = 1.0


@reference(CircleParams())
def circle(p, t):
    """A circle."""
    return Two(p.radius * math.cos(3 * t) - p.radius, p.radius * math.sin(3 * t))


class TablePlantParams(NamedTuple):
    x: MassParams = MassParams()
    y: MassParams = MassParams(mass=2.0)


class TablePlantState(NamedTuple):
    x: MassState = MassState()
    y: MassState = MassState()


def table_output(s):
    """Both positions."""
    return Two(s.x.position, s.y.position)


@plant(TablePlantParams(), TablePlantState(), output=table_output)
def table(p, s, u):
    """Two axes: a plant of two plants."""
    return TablePlantState(mass(p.x, s.x, u.x), mass(p.y, s.y, u.y))


class TwoPIDParams(NamedTuple):
    x: PIDParams = PIDParams()
    y: PIDParams = PIDParams(kp=2.5)


class TwoPIDState(NamedTuple):
    x: PIDState = PIDState()
    y: PIDState = PIDState()


@controller(TwoPIDParams(), TwoPIDState())
def two_pids(p, s, command, feedback, dt):
    """One PID an axis."""
    x, ux = pid(p.x, s.x, command.x, feedback.x, dt)
    y, uy = pid(p.y, s.y, command.y, feedback.y, dt)
    return TwoPIDState(x, y), Two(ux, uy)


class CascadeParams(NamedTuple):
    outer: PIDParams = PIDParams(kp=8.0, ki=0.0, kd=0.0)
    inner: PIDParams = PIDParams(kp=0.4, ki=1.0, kd=0.0)
    every: int = 4


class CascadeState(NamedTuple):
    outer: PIDState = PIDState()
    inner: PIDState = PIDState()
    wanted: float = 0.0
    count: int = 0


@controller(CascadeParams(), CascadeState())
def cascade(p, s, command, feedback, dt):
    """A position loop every n-th period around a velocity loop every period."""
    outer, wanted = s.outer, s.wanted
    if s.count % p.every == 0:
        outer, wanted = pid(p.outer, s.outer, command, feedback.position, dt * p.every)
    inner, u = pid(p.inner, s.inner, wanted, feedback.velocity, dt)
    return CascadeState(outer, inner, wanted, s.count + 1), u


class ObserverParams(NamedTuple):
    inner: PIDParams = PIDParams()
    gain: float = 30.0
    plant_gain: float = 10.0


class ObserverState(NamedTuple):
    inner: PIDState = PIDState()
    estimate: float = 0.0
    model: float = 0.0
    last: float = 0.0


@controller(ObserverParams(), ObserverState())
def observed(p, s, command, feedback, dt):
    """A disturbance observer wrapped around a controller."""
    inner, wanted = pid(p.inner, s.inner, command, feedback, dt)
    model = s.model + (p.plant_gain * s.last + p.gain * (feedback - s.model)) * dt
    estimate = p.gain * (feedback - model) / p.plant_gain
    u = wanted - estimate
    return s._replace(inner=inner, estimate=estimate, model=model, last=u), u
