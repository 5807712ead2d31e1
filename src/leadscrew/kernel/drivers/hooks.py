"""What a driver leaves open; the linker binds each to the loop's own code. Called unlinked, each is an error."""

from __future__ import annotations

from typing import Any, NamedTuple, NoReturn


class Constant(NamedTuple):
    """A number that the linker puts into a driver."""

    name: str

    def __index__(self) -> int:
        raise TypeError(f"the hook {self.name} is not linked")


PARAMS: Any = Constant("PARAMS")
"""How many scalar parameters the loop has (at least 1)."""
STATES: Any = Constant("STATES")
"""How many scalar states the loop has (at least 1)."""
DRIVES: Any = Constant("DRIVES")
"""How many numbers go from the actuator and the disturbance to the plant."""
ROW: Any = Constant("ROW")
"""How many numbers can be recorded in a period."""
LANES: Any = Constant("LANES")
"""How many runs lie side by side."""
RECORDING: Any = Constant("RECORDING")
"""Whether this copy of the driver records signals."""
ORDER: Any = Constant("ORDER")
"""How many states the integrator integrates."""
RTOL: Any = Constant("RTOL")
"""Relative tolerance of the adaptive integrator."""
ATOL: Any = Constant("ATOL")
"""Absolute tolerance of the adaptive integrator, in the units of each state."""
TIMED: Any = Constant("TIMED")
"""Whether the derivative depends on time."""


def _open(*_: Any) -> NoReturn:
    raise NotImplementedError("a hook of a driver was called before it was linked")


# ---- the blocks
def reference(p, s, t, dt, noise):
    """State and command."""
    _open(p, s, t, dt, noise)


def disturbance(p, s, t, dt, noise):
    """State and load."""
    _open(p, s, t, dt, noise)


def output_disturbance(p, s, t, dt, noise):
    """State and what is added to the plant's output."""
    _open(p, s, t, dt, noise)


def plant_output(p, s):
    """What the plant shows."""
    _open(p, s)


def disturbed(actual, offset):
    """The plant's output with the output disturbance."""
    _open(actual, offset)


def sensor(p, s, actual, t, dt, noise):
    """State and feedback."""
    _open(p, s, actual, t, dt, noise)


def controller(p, s, command, feedback, t, dt):
    """State (its derivative in a continuous loop) and output."""
    _open(p, s, command, feedback, t, dt)


def actuator(p, s, output, t, dt):
    """State and what is applied."""
    _open(p, s, output, t, dt)


def derivative(p, s, u, load, t):
    """Time derivative of the plant's state."""
    _open(p, s, u, load, t)


def plant_step(p, s, memory, u, load, t, dt):
    """State after ``dt`` and the integrator's memory."""
    _open(p, s, memory, u, load, t, dt)


def metrics(p, s, command, actual, feedback, output, t, dt):
    """State of all metrics."""
    _open(p, s, command, actual, feedback, output, t, dt)


# ---- delay lines
def send(line, applied, k):
    """Notes what the actuator applies in period ``k``."""
    _open(line, applied, k)


def sent(line, applied, k, j, substeps):
    """What reaches the plant in substep ``j`` of period ``k``."""
    _open(line, applied, k, j, substeps)


def watch(line, p, plant, n):
    """Notes the plant's output at substep ``n`` since the start."""
    _open(line, p, plant, n)


def seen(line, actual, k, substeps):
    """What the sensor sees at the start of period ``k``."""
    _open(line, actual, k, substeps)


# ---- types and their places
def LoopState(  # noqa: N802
    reference, disturbance, output_disturbance, sensor, controller, actuator, plant, integrator, sent, seen, metrics
):
    """The state of the whole loop."""
    _open(reference, disturbance, output_disturbance, sensor, controller, actuator, plant, integrator, sent, seen)


def Signals(command, feedback, output, applied, actual, load):  # noqa: N802
    """The signals of one period."""
    _open(command, feedback, output, applied, actual, load)


def params_of(P, A):
    """Parameters from the flat vectors."""
    _open(P, A)


def state_of(S, B):
    """State from the flat vectors."""
    _open(S, B)


def keep_state(S, s):
    """Writes the scalar state into its vector."""
    _open(S, s)


def param_views(A):
    """Array parameters of all lanes."""
    _open(A)


def state_views(B):
    """Array states of all lanes."""
    _open(B)


def lane_params(Q, views, lane):
    """Parameters of one lane."""
    _open(Q, views, lane)


def lane_state(Z, views, lane):
    """State of one lane."""
    _open(Z, views, lane)


def keep_lane(Z, lane, s):
    """Writes the scalar state of one lane, but for the plant's and the integrator's."""
    _open(Z, lane, s)


def keep_lane_plant(Z, lane, plant, memory):
    """Writes the plant's and the integrator's scalar state of one lane."""
    _open(Z, lane, plant, memory)


def keep_sensed(X, command, feedback, load):
    """Command, feedback and load side by side."""
    _open(X, command, feedback, load)


def given_output(X):
    """The controller's output from beside them."""
    _open(X)


def given_load(X):
    """The load back."""
    _open(X)


def keep_drive(U, lane, applied, load):
    """Writes what goes to the plant of one lane."""
    _open(U, lane, applied, load)


def lane_applied(U, lane):
    """What the actuator of one lane applies."""
    _open(U, lane)


def lane_load(U, lane):
    """The load on the plant of one lane."""
    _open(U, lane)


def keep_row(R, lane, x, s, t):
    """Writes all that can be recorded in a period."""
    _open(R, lane, x, s, t)


def keep_metrics(M, run, p, s):
    """Writes the values of the metrics."""
    _open(M, run, p, s)


def settled(plant):
    """The plant's state with denormal tails set to zero."""
    _open(plant)


def state_sound(s):
    """Whether every state is finite."""
    _open(s)


def signals_sound(x, bound):
    """Whether output and true output are finite and the true output within the bound."""
    _open(x, bound)


# ---- integrators
def along(s, h, k):
    """``s + h k`` over the plant's state."""
    _open(s, h, k)


def weighted(s, h, k1, k2, k3, k4):
    """``s + h (k1 + 2 k2 + 2 k3 + k4)`` over the plant's state."""
    _open(s, h, k1, k2, k3, k4)


def spread(s, x):
    """Writes the integrated state into a vector."""
    _open(s, x)


def gathered(s, x):
    """The state with the integrated part read from a vector."""
    _open(s, x)


def spread_rates(s, controller, plant, f):
    """Writes the derivatives of controller and plant into a vector."""
    _open(s, controller, plant, f)


def remembered(s, h):
    """The state with the integrator's memory set."""
    _open(s, h)


def rates(p, s, u, load, t, x, f):
    """Writes the derivative at the vector ``x`` into ``f``."""
    _open(p, s, u, load, t, x, f)


def jacobian(p, s, u, load, t, x, f, jac):
    """Writes the Jacobian of the derivative at ``x`` into ``jac``."""
    _open(p, s, u, load, t, x, f, jac)


# ---- arrays of the lanes
def fill_params(QA, A, lane):
    """Copies the array parameters into one lane."""
    _open(QA, A, lane)


def fill_states(ZB, B, lane):
    """Copies the array states into one lane."""
    _open(ZB, B, lane)


def set_param(QA, place, lane, value):
    """Sets one element of one lane's array parameters."""
    _open(QA, place, lane, value)


def set_state(ZB, place, lane, value):
    """Sets one element of one lane's array states."""
    _open(ZB, place, lane, value)
