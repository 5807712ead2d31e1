"""Linear loops: from transfer functions (:func:`continuous_loop`) or from a built loop (:func:`sampled_loop`).

The linear loop of a built :class:`~leadscrew.kernel.loop.Loop`: from the very steps that run and are exported.

Every block's step is called on unit states and a unit input, from its state at rest and with the command at zero; the
differences are the columns of its matrices. For a linear step they are exact. Whatever only depends on time (lines of
a disturbance, noise) cancels in the difference, and states that the error does not reach or the output does not show
are left out. Delays become states: the outputs sent but not yet at the plant.

The path is the one of the feedback: with a command of zero, ``feedback = -e``. A 2-DOF controller thus enters with what
decides its stability, its path from the feedback. Under commands that are not zero the matrices have to be the same: a
controller that schedules on the command or adapts to it is refused.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.analysis.stability.linear import SMALLEST_RAD_S, LinearLoop, modes, phase_crossings
from leadscrew.kernel.block import Block
from leadscrew.kernel.frame import pairs
from leadscrew.kernel.layout import Layout, leaves
from leadscrew.kernel.loop import Loop
from leadscrew.kernel.noise import Noise
from leadscrew.plants._linear import hold_matrices
from leadscrew.util.errors import ValueRefused

if TYPE_CHECKING:
    from leadscrew.kernel.block import Block


SMALL = 2.0**-30
"""Size of the unit: a power of two, so that the differences of a linear step from rest at zero carry no rounding."""
TRIED = (2.0**-20, 2.0**-12, 2.0**-7)
"""Sizes at which a step must be linear: 1 nm to 8 um for a loop in mm."""
LARGE = 1e4
"""Size at which a limit would show."""
EQUAL = 1e-9

Flat = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]
"""State and input numbers to next state and output numbers."""


class Linear:
    """A block's matrices: ``x+ = a x + b u``, ``y = c x + d u``."""

    def __init__(self, f: Flat, order: int, inputs: int, rest: np.ndarray) -> None:
        def at(x: np.ndarray, u: np.ndarray) -> np.ndarray:
            return np.concatenate(f(rest + x, u))

        zero = at(np.zeros(order), np.zeros(inputs))
        size = SMALL if not zero.any() and not rest.any() else 1.0
        columns = []
        for k in range(order + inputs):
            z = np.zeros(order + inputs)
            z[k] = size
            columns.append((at(z[:order], z[order:]) - zero) / size)
        self.whole = np.array(columns).T.reshape(len(zero), order + inputs)
        self.order, self.inputs, self.outputs = order, inputs, len(zero) - order
        self.zero, self.at = zero, at
        a, b, _, _ = self.matrices
        reached = b.any(axis=1)
        for _ in range(order):
            reached = reached | ((a != 0.0) @ reached)
        self.live = np.concatenate([reached, np.ones(inputs, dtype=bool)])

    @property
    def matrices(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """a, b, c, d."""
        n = self.order
        return self.whole[:n, :n], self.whole[:n, n:], self.whole[n:, :n], self.whole[n:, n:]

    def follows(self, size: float) -> bool:
        """Whether the step is the matrices' at states and inputs of this size, in two arbitrary directions.

        Only of states that the inputs reach: a flag of the first period stays as it is.
        """
        directions = np.cos(np.outer((1.7, 5.3), np.arange(1, self.order + self.inputs + 1))) * self.live
        for z in size * directions:
            expected = self.whole @ z
            seen = self.at(z[: self.order], z[self.order :]) - self.zero
            scale = np.abs(self.whole) @ np.abs(z) + 1e-300
            # next to values of the size of the rest point nothing finer than rounding can be seen
            if np.any(np.abs(seen - expected) > EQUAL * scale + 4e-16 * np.abs(self.zero)):
                return False
        return True

    def linear(self) -> bool:
        """Whether the step is linear at every size tried."""
        return all(self.follows(size) for size in TRIED)


def flat_step(
    loop: Loop, slot: str, given: Callable[[np.ndarray], dict[str, Any]], t: float
) -> tuple[Flat, int, np.ndarray]:
    """A block's step on plain numbers, how many its state has, and its state at rest."""
    block: Block = loop.blocks[slot]  # type: ignore[assignment]
    lead = [loop.prepared(block, slot)] if block.params is not None else []
    state = None if block.state is None else loop.start_state(block)
    layout = Layout(0.0 if state is None else state)
    scalars = len(layout.scalars) if state is not None else 0
    rest = np.zeros(0)
    if state is not None:
        s, v = layout.pack(state)
        rest = np.concatenate([s[:scalars], v[: layout.array_size]])
    noise = Noise(loop.seed, 0, 0, 0)
    dt = loop.step if slot == "plant" else loop.period

    def f(x: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        signals = {"t": t, "dt": dt, "noise": noise, **given(u)}
        args = [signals[n] for n in block.signals]
        if state is None:
            return np.zeros(0), numbers(block.step(*lead, *args))
        held = layout.unpack(x[:scalars] if scalars else np.zeros(1), x[scalars:] if layout.array_size else np.zeros(1))
        result = block.step(*lead, held, *args)
        following, shown = (result, 0.0) if slot == "plant" else result
        s, v = layout.pack(following)
        moved = np.concatenate([s[:scalars], v[: layout.array_size]])
        return moved, np.zeros(0) if slot == "plant" else numbers(shown)

    return f, len(rest), rest


def numbers(signal: Any) -> np.ndarray:
    layout = Layout(signal if isinstance(signal, tuple) else float(signal))
    return layout.pack(signal)[0][: len(layout.scalars)].astype(float)


def filled(example: Any, numbers: np.ndarray) -> Any:
    return Layout(example).unpack(np.asarray(numbers, dtype=float), np.zeros(1))


COMMANDS = (2.0**-7, -(2.0**-5))
"""Commands (and their derivatives) under which a controller must have the matrices that it has at zero: 8 and 31 um."""
FAR_COMMANDS = (1.0, -300.0)
"""The same for a controller without a limit of its output."""

LARGEST_ORDER = 400
"""Most numbers in a controller's state: a memory of samples makes poles by the thousand, and its place in it moves."""


def sampled_loop(loop: Loop, name: str = "") -> LinearLoop:
    """The sampled linear loop, cut at the error, of a loop whose controller and plant are linear.

    A sensor or actuator that is not linear (quantised, saturating, with a dead zone) counts as ideal, and the loop's
    notes say so. A plant that gives a derivative is taken by its exact zero-order hold.

    Raises:
        ValueRefused: a loop without a period; a controller or plant that is not linear; a controller with a memory of
            more than 400 numbers (repetitive control); signals of several axes.
    """
    if loop.continuous:
        raise ValueRefused(f"{loop.name}: has no period; take continuous_loop for a continuous one")
    notes: list[str] = []
    feedback_leaf, command = _position(loop)
    plant, read = _plant(loop)
    sensor = _part(loop, "sensor", "actual", "actual", notes)
    controller = _controller(loop, command, notes)
    actuator = _part(loop, "actuator", "output", "output", notes)
    a, b, c, d = _join(loop, plant, read, sensor, controller, actuator, feedback_leaf)
    a, b, c = _pruned(a, b, c)
    return LinearLoop(a, b, c, d, loop.period, name=name or loop.name, notes=tuple(notes), from_blocks=True)


def _position(loop: Loop) -> tuple[int, Any]:
    """Place of the position among the feedback's numbers, and a command of zero."""
    command, feedback = (Layout(loop.signals[k]) for k in ("command", "feedback"))
    compared = pairs(command.tree, feedback.tree)
    if len(compared) != 1:
        raise ValueRefused(f"{loop.name}: compares {len(compared)} axes; a stability analysis takes one at a time")
    place = [leaf.key for leaf in leaves(feedback.tree)].index(compared[0].other)
    return place, command.unpack(np.zeros(max(1, len(command.scalars))), np.zeros(1))


def _controller(loop: Loop, command: Any, notes: list[str]) -> Linear:
    example = loop.signals["feedback"]
    inputs = len(Layout(example).scalars)
    f, order, rest = flat_step(loop, "controller", lambda u: {"command": command, "feedback": filled(example, u)}, 0.0)
    block: Block = loop.blocks["controller"]  # type: ignore[assignment]
    if order > LARGEST_ORDER:
        raise ValueRefused(
            f"{block.name}: its state holds {order} numbers; a stability analysis takes controllers of up to "
            f"{LARGEST_ORDER}. Repetitive control has a condition of its own: contraction() of "
            "leadscrew.controllers._repetitive"
        )
    found = Linear(f, order, inputs, rest)
    if not found.linear():
        raise ValueRefused(
            f"{block.name}: this controller is not linear in its error; take it apart by lure(), and analyse its "
            "linear part with the sector of its nonlinearity"
        )
    free = found.follows(LARGE)
    _check_commands(loop, found, (*COMMANDS, *FAR_COMMANDS) if free else COMMANDS)
    if not free:
        notes.append(
            f"The controller {block.name} is linear for small errors only (a limit of its output, say): what is proved "
            "holds while the limit is not reached."
        )
    return found


def _signals(command: Any, shape: Any, at: np.ndarray, u: np.ndarray) -> dict[str, Any]:
    """What a controller gets: a command, and a feedback that differs by ``u`` from what it is ``at``."""
    return {"command": command, "feedback": filled(shape, at + u)}


def _check_commands(loop: Loop, found: Linear, commands: tuple[float, ...]) -> None:
    """Refuses a controller whose matrices depend on the command, by its step under commands that are not zero."""
    block: Block = loop.blocks["controller"]  # type: ignore[assignment]
    shape, seen = loop.signals["command"], loop.signals["feedback"]
    place = _position(loop)[0]
    for size in commands:
        # every number of the command is of this size: a position, and its derivatives where it is a motion
        command = filled(shape, np.full(max(1, len(Layout(shape).scalars)), size))
        at = np.zeros(found.inputs)
        at[place] = size
        given = partial(_signals, command, seen, at)
        f, order, rest = flat_step(loop, "controller", given, 0.0)
        under = Linear(f, order, found.inputs, rest).whole
        apart = np.abs(under - found.whole)[:, found.live]
        scale = np.abs(found.whole).max(axis=1, keepdims=True)
        if np.any(apart > EQUAL * scale + 1e-12):
            raise ValueRefused(
                f"{block.name}: under a command of {size:g} it answers an error otherwise than under none: it "
                "schedules on the command or adapts to it, so it has no one linear loop"
            )


def _part(loop: Loop, slot: str, signal: str, example: str, notes: list[str]) -> Linear | None:
    """The matrices of a sensor or actuator; None where there is none or it is not linear."""
    block = loop.blocks[slot]
    if block is None:
        return None
    shape = loop.signals[example]
    f, order, rest = flat_step(loop, slot, lambda u: {signal: filled(shape, u)}, 0.0)
    found = Linear(f, order, len(Layout(shape).scalars), rest)
    if not (found.linear() and found.follows(LARGE)):
        notes.append(f"The {slot} {block.name} is not linear; it counts as ideal here.")
        return None
    return found


def _plant(loop: Loop) -> tuple[Linear, np.ndarray]:
    """The plant over one integration step, and the row of what it shows."""
    block: Block = loop.blocks["plant"]  # type: ignore[assignment]
    shape, load = loop.signals["applied"], loop.signals["load"]
    none = filled(load, np.zeros(len(Layout(load).scalars)))
    inputs = len(Layout(shape).scalars)
    parts = []
    for t in (0.0, 7.0 * loop.period):
        f, order, rest = flat_step(loop, "plant", lambda u: {"u": filled(shape, u), "load": none}, t)
        parts.append(Linear(f, order, inputs, rest))
    found = parts[0]
    if not (found.linear() and found.follows(LARGE)) or not np.allclose(parts[1].whole, found.whole, 1e-9, 0.0):
        raise ValueRefused(
            f"{block.name}: this plant is not linear (friction, backlash or a limit in it); give the loop a linear "
            "model of it for a stability analysis"
        )
    if "dt" not in block.signals:
        a, b = found.whole[:, :order], found.whole[:, order:]
        moved = [hold_matrices(a, b[:, j], loop.step) for j in range(inputs)]
        found.whole = np.column_stack([moved[0][0], *(drive for _, drive in moved)])
    params, state = loop.prepared(block, "plant"), loop.start_state(block)
    layout = Layout(state)
    shown = block.output if block.output is not None else block.state._fields[0]
    count = len(layout.scalars)

    def read(x: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        held = layout.unpack(x[:count] if count else np.zeros(1), x[count:] if layout.array_size else np.zeros(1))
        if not callable(shown):
            for part in str(shown).split("."):
                held = getattr(held, part)
            return np.zeros(0), numbers(held)
        wanted = shown.__code__.co_varnames[: shown.__code__.co_argcount]
        return np.zeros(0), numbers(shown(*({"p": params, "s": held}[n] for n in wanted)))

    scalars, arrays = layout.pack(state)
    rest = np.concatenate([scalars[:count], arrays[: layout.array_size]])
    out = Linear(lambda x, u: read(x, u), 0, 0, np.zeros(0)) if order == 0 else _rows(read, rest)
    return found, out.whole


def _rows(read: Flat, rest: np.ndarray) -> Linear:
    """What a plant shows, as rows on its state."""
    found = Linear(lambda _, x: read(rest + x, x), 0, len(rest), np.zeros(0))
    if not found.linear():
        raise ValueRefused("this plant's output is not a linear function of its state")
    return found


def _join(
    loop: Loop, plant: Linear, read: np.ndarray, sensor: Linear | None, controller: Linear, actuator: Linear | None,
    place: int,
) -> tuple[np.ndarray, ...]:  # fmt: skip
    """The loop over one period, from the error to the sensed position.

    The state is plant, sensor, controller, actuator and the line of outputs on their way, latest first.
    """
    whole, part = divmod(loop.sent + loop.seen, loop.substeps)
    waiting = whole + (1 if part else 0)
    ap, bp = plant.whole[:, : plant.order], plant.whole[:, plant.order :]
    inputs = bp.shape[1]
    late, early = _held(ap, bp, part), _held(ap, bp, loop.substeps - part)
    sizes = [plant.order, sensor.order if sensor else 0, controller.order, actuator.order if actuator else 0]
    at = np.concatenate([[0], np.cumsum(sizes)]).astype(int)
    order = int(at[-1]) + waiting * inputs
    # rows over (state, e); a signal is such rows
    state = np.eye(order, order + 1)
    error = np.zeros((1, order + 1))
    error[0, -1] = 1.0
    measured = read @ state[: at[1]]
    moved = np.zeros((order, order + 1))
    if sensor is not None:
        measured, moved[at[1] : at[2]] = _through(sensor, state[at[1] : at[2]], measured)
    seen = measured.copy()
    seen[place] = -error[0]
    output, moved[at[2] : at[3]] = _through(controller, state[at[2] : at[3]], seen)
    if actuator is not None:
        output, moved[at[3] : at[4]] = _through(actuator, state[at[3] : at[4]], output)
    line = [output, *(state[at[4] + i * inputs : at[4] + (i + 1) * inputs] for i in range(waiting))]
    x = state[: at[1]]
    if part:
        x = late[0] @ x + late[1] @ line[whole + 1]
    moved[: at[1]] = early[0] @ x + early[1] @ line[whole]
    for i in range(waiting):
        moved[at[4] + i * inputs : at[4] + (i + 1) * inputs] = line[i]
    shown = measured[place : place + 1]
    return moved[:, :-1], moved[:, -1:], shown[:, :-1], shown[:, -1:]


def _through(block: Linear, state: np.ndarray, given: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What a block puts out, and its next state."""
    a, b, c, d = block.matrices
    return c @ state + d @ given, a @ state + b @ given


def _held(a: np.ndarray, b: np.ndarray, steps: int) -> tuple[np.ndarray, np.ndarray]:
    """``steps`` integration steps under a constant input."""
    order, inputs = b.shape
    one = np.block([[a, b], [np.zeros((inputs, order)), np.eye(inputs)]])
    whole = np.linalg.matrix_power(one, steps)
    return whole[:order, :order], whole[:order, order:]


def _pruned(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The states that the error reaches and the output shows, by which entries are zero."""
    reached, shown = b[:, 0] != 0.0, c[0] != 0.0
    for _ in range(len(a)):
        reached = reached | ((a != 0.0) @ reached)
        shown = shown | (shown @ (a != 0.0))
    kept = reached & shown
    return a[np.ix_(kept, kept)], b[kept], c[:, kept]


def continuous_loop(
    controller_num: Sequence[float],
    controller_den: Sequence[float],
    plant_num: Sequence[float],
    plant_den: Sequence[float],
    dead_time: float = 0.0,
    name: str = "",
) -> LinearLoop:
    """The continuous loop of two transfer functions in ``s`` (highest power first) and a dead time in s.

    Raises:
        ValueRefused: a loop that is not proper, has a zero denominator, or feeds through with a dead time.
    """
    num = np.trim_zeros(np.polymul(controller_num, plant_num), "f")
    den = np.trim_zeros(np.polymul(controller_den, plant_den), "f")
    if len(den) == 0:
        raise ValueRefused(f"loop {name!r}: its denominator is zero")
    if len(num) > len(den):
        raise ValueRefused(
            f"loop {name!r}: its numerator's degree {len(num) - 1} exceeds the denominator's {len(den) - 1}; give the "
            "derivative a filter"
        )
    a, b, c, d = realised(num, den)
    return LinearLoop(a, b, c, d, None, float(dead_time), name)


def realised(num: np.ndarray, den: np.ndarray) -> tuple[np.ndarray, ...]:
    """Controllable companion form in time units that make the denominator's coefficients alike."""
    order = len(den) - 1
    num, den = np.asarray(num, dtype=float) / den[0], np.asarray(den, dtype=float) / den[0]
    num = np.concatenate([np.zeros(order + 1 - len(num)), num])
    d = num[0]
    rest = num[1:] - d * den[1:]
    sizes = [abs(den[k]) ** (1.0 / k) for k in range(1, order + 1) if den[k] != 0.0]
    fast = max(sizes, default=1.0)
    scaled = fast ** np.arange(1, order + 1)
    a = np.eye(order, k=-1)
    a[0, :] = -den[1:] / scaled
    b = np.zeros((order, 1))
    if order:
        b[0, 0] = fast
    return fast * a, b, (rest / scaled)[None, :], np.array([[d]])


FAST = 0.05
"""Poles with ``|z|`` below this count as delay."""
POINTS = 200
ROUGH = 0.05
"""Misfit from which the model says so."""
REACH = 1.2
"""The fit's upper end, in phase crossover frequencies."""


def continuous_model(loop: LinearLoop) -> LinearLoop:
    """The continuous model of a sampled loop: the same poles and a dead time, fitted to its frequency response.

        G(e^(jwT))  ~  e^(-jw tau) num(jw) / prod_i (jw - s_i),        s_i = log(z_i) / T for the slow poles z_i

    Poles near ``z = 0`` (delays, the backward difference) become dead time. For a given ``tau`` the numerator follows
    by linear least squares of the relative error up to the phase crossover; ``tau`` is the best one. The model's notes
    say how well it fits. What is proved for it is not proved for the sampled loop.

    Raises:
        ValueRefused: a loop that is continuous, or one with a pole on the negative real axis of ``z``, which no real
            continuous loop of the same order has.
    """
    from scipy.optimize import minimize_scalar

    if loop.dt is None:
        raise ValueRefused(f"continuous_model: the loop {loop.name!r} is continuous already")
    z = np.linalg.eigvals(loop.a).astype(complex)
    z = z[np.abs(z) > FAST]
    if np.any((np.abs(z.imag) < 1e-9) & (z.real < 0.0)):
        raise ValueRefused(
            f"continuous_model: the loop {loop.name!r} has a pole at z = {z[np.argmin(z.real)].real:.3g}, an "
            "oscillation at half the sampling rate, which no continuous loop of the same order has"
        )
    s = np.log(z) / loop.dt
    s[np.abs(s) < 1e-7 / loop.dt] = 0.0
    crossed = phase_crossings(loop)
    top = min(REACH * crossed[0].w, 0.9 * loop.nyquist) if crossed else 0.3 * loop.nyquist
    slow = np.abs(modes(loop))
    low = 0.1 * float(slow[slow > SMALLEST_RAD_S].min(initial=1e-2 * top))
    w = np.concatenate([np.geomspace(low, top, POINTS), np.linspace(0.1 * top, top, POINTS)])
    g = loop.response(w)
    den = np.real(np.poly(s))
    order = len(s)

    def fitted(tau: float) -> tuple[np.ndarray, float]:
        base = np.exp(-1j * w * tau) / np.polyval(den, 1j * w)
        # numerator in units of the band, or its powers would differ by tens of decades
        columns = np.column_stack([base * (1j * w / top) ** (order - 1 - k) for k in range(order)]) / g[:, None]
        matrix = np.vstack([columns.real, columns.imag])
        wanted = np.concatenate([np.ones(len(w)), np.zeros(len(w))])
        num, *_ = np.linalg.lstsq(matrix, wanted, rcond=None)
        return num / top ** np.arange(order - 1, -1, -1), float(np.sqrt(np.mean(np.abs(columns @ num - 1.0) ** 2)))

    tried = np.linspace(0.0, len(loop.a) * loop.dt, 40)
    k = int(np.argmin([fitted(t)[1] for t in tried]))
    sought = minimize_scalar(
        lambda t: fitted(t)[1], bounds=(tried[max(k - 1, 0)], tried[min(k + 1, len(tried) - 1)]), method="bounded",
        options={"xatol": 1e-9 * loop.dt},
    )  # fmt: skip
    tau = max(float(sought.x), 0.0)
    num, off = fitted(tau)
    a, b, c, d = realised(num, den)
    note = (
        f"The continuous model has a dead time of {1e3 * tau:.4g} ms and fits the sampled response within "
        f"{100 * off:.2g} % (rms) up to {top / (2 * np.pi):.4g} Hz."
        + (" That is too far off to conclude anything about the sampled loop." if off > ROUGH else "")
    )
    return LinearLoop(a, b, c, d, None, tau, f"continuous model of {loop.name}", (*loop.notes, note))


def pid_polynomials(kp: float, ki: float, kd: float, filter_s: float = 0.0) -> tuple[list[float], list[float]]:
    """Numerator and denominator of ``kp + ki/s + kd s/(1 + filter_s s)``; without ``ki`` there is no pole at 0."""
    if ki == 0.0:
        return [kd + kp * filter_s, kp], [filter_s, 1.0]
    return [kd + kp * filter_s, kp + ki * filter_s, ki], [filter_s, 1.0, 0.0]
