"""The linear view of a loop around an operating point, as objects of python-control.

    x(k+1) = A x(k) + B w(k),   z(k) = C x(k) + D w(k)        sampled: one period, delays among the states
    dx/dt  = A x + B w,         z    = C x + D w              continuous (``period=None``)

Every block is replaced by the Jacobian of its step at the point, from differences of the very step that runs; for a
linear step they are exact. A plant that gives its derivative is held exactly (zero-order hold) over each integration
step. Two systems come out:

- the open loop, cut at the feedback: from ``error`` to ``feedback``, with the sign of negative feedback;
- the closed loop: from ``command`` and ``disturbance`` to ``actual`` and ``output``, feed-forward included.

The point is at rest where the loop starts (error zero, the default), or where a run is at a time. A block that is not
smooth there (a relay, a quantiser) is refused by name; a sensor or an actuator may count as ideal instead.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.analysis.stability.linear import LinearLoop
from leadscrew.analysis.stability.loop import Linear, filled, flat_step, numbers
from leadscrew.kernel import validate
from leadscrew.kernel.frame import pairs, under
from leadscrew.kernel.layout import Layout, leaves
from leadscrew.kernel.noise import Noise
from leadscrew.kernel.parameters import checked_replace, nearest
from leadscrew.plants._linear import hold_matrices
from leadscrew.util.errors import NameUnknown, ValueRefused

if TYPE_CHECKING:
    from control import StateSpace, TimeResponseData

    from leadscrew.analysis.stability.margins import Margins
    from leadscrew.kernel.block import Block
    from leadscrew.kernel.loop import Loop

Flat = Callable[[np.ndarray], np.ndarray]

STEPS = 2.0 ** -np.arange(6.0, 40.0, 3.0)
"""Steps of the differences, as a share of the size of what is moved (of 1 below 1)."""
ROUNDING = 2.0**-50
CONVERGED = 1e-4
"""How far two differences of neighbouring steps may part, as a share, where there is a derivative."""
SETTLING = 64
"""Periods after which the flags of a block stay, where they ever do."""
CONSTANT = 1e-11
"""Size of a singular value, as a share of the largest, that counts as none."""
KINK = 1e-3
"""Share by which the slopes on both sides differ at a kink."""


@dataclass(frozen=True)
class Linearization:
    """The linear view of a loop at one operating point."""

    open_loop: StateSpace
    """From ``error`` to ``feedback``, the loop cut there: ``L`` of ``1 / (1 + L)``."""
    closed_loop: StateSpace
    """From ``command`` and ``disturbance`` to ``actual`` and ``output``, named as recorded (``command_position``)."""
    point: dict[str, Any]
    """The signals at the point: command, feedback, output, applied, actual, disturbance."""
    cut: LinearLoop | None = field(default=None, repr=False)
    """The open loop for :mod:`leadscrew.analysis.stability`; none where several axes are compared."""
    positions: tuple[tuple[str, str], ...] = field(default=(), repr=False)
    """Names of each axis' command and of the true output that follows it."""

    def __repr__(self) -> str:
        dt = self.open_loop.dt
        kind = f"sampled, {dt:g} s" if dt else "continuous"
        return (
            f"<Linearization {self.open_loop.name}: {kind}; open loop of order {self.open_loop.nstates}, closed loop "
            f"{', '.join(self.closed_loop.input_labels)} -> {', '.join(self.closed_loop.output_labels)}>"
        )


def linearize(
    loop: Loop, time: float | None = None, state: Mapping[str, float] | None = None, ideal: Sequence[str] = ()
) -> Linearization:
    """The linear view of a loop around an operating point.

    Args:
        loop: sampled or continuous.
        time: seconds after which a run's states are the point; at rest at the start where not given: the command is
            where the feedback is.
        state: states of the point by dotted key (``plant.speed``), instead of those of the run or of the start.
        ideal: ``sensor``, ``actuator`` or both: counted as ideal, whatever they do.

    Raises:
        ValueRefused: a block has no linear view there; a block that does not answer at all there.
        NameUnknown: no such state.
    """
    for slot in ideal:
        validate.one_of("ideal", slot, ["sensor", "actuator"])
    point = _Point(loop, time, dict(state or {}), tuple(ideal))
    parts = _Parts(point)
    pairs_of = pairs(Layout(loop.signals["command"]).tree, Layout(loop.signals["feedback"]).tree)
    a, b, c, d = parts.joined([p.other for p in pairs_of])
    names = parts.names
    open_a, open_b, open_c, open_names = _minimal(a, b, c, names)
    from control import ss

    dt = 0.0 if loop.continuous else loop.period
    errors = [_plain(under("error", p.suffix.removeprefix("."))) for p in pairs_of]
    seen = [_plain(under("feedback", p.other)) for p in pairs_of]
    label = _plain(loop.name)
    opened = ss(open_a, open_b, open_c, d, dt, inputs=errors, outputs=seen, states=open_names or None, name=label)
    ca, cb, cc, cd = parts.joined(None)
    ca, cb, cc, closed_names = _minimal(ca, cb, cc, names)
    closed = ss(ca, cb, cc, cd, dt, inputs=parts.inputs, outputs=parts.outputs, states=closed_names or None, name=label)
    shown = pairs(Layout(loop.signals["command"]).tree, Layout(loop.signals["actual"]).tree)
    cut = None
    if len(pairs_of) == 1:
        free_a, free_b, free_c = _without_constants(open_a, open_b, open_c, sampled=not loop.continuous)
        notes = ("A state that nothing moves and nothing shows is left out.",) if len(free_a) < len(open_a) else ()
        cut = LinearLoop(
            free_a,
            free_b,
            free_c,
            d,
            None if loop.continuous else loop.period,
            name=loop.name,
            notes=notes,
            from_blocks=True,
        )
        if not len(open_a) and not d.any():
            parts.refuse_cut()
    return Linearization(
        opened, closed, point.signals, cut,
        tuple((_plain(under("command", p.command)), _plain(under("actual", p.other))) for p in shown),
    )  # fmt: skip


def margins(
    loop: Loop, time: float | None = None, state: Mapping[str, float] | None = None, ideal: Sequence[str] = ()
) -> Margins:
    """Margins of the loop at an operating point, of the linear view that :func:`linearize` gives.

    Raises:
        ValueRefused: what :func:`linearize` refuses; a loop of several axes.
    """
    from leadscrew.analysis.stability.margins import margins as margins_of

    linear = linearize(loop, time, state, ideal)
    if linear.cut is None:
        raise ValueRefused(
            f"{loop.name}: compares {linear.open_loop.ninputs} axes, and margins are of one; take linearize().open_loop"
        )
    return margins_of(linear.cut)


def step_response(
    loop: Loop,
    duration: float | None = None,
    time: float | None = None,
    state: Mapping[str, float] | None = None,
    ideal: Sequence[str] = (),
) -> TimeResponseData:
    """The true output after a unit step of the command, of the closed loop that :func:`linearize` gives.

    A command with velocity and acceleration steps in position alone. Of several axes every pair is computed.

    Args:
        loop: sampled or continuous.
        duration: seconds; chosen from the poles where not given.
        time: as for :func:`linearize`.
        state: as for :func:`linearize`.
        ideal: as for :func:`linearize`.
    """
    import control

    found = linearize(loop, time, state, ideal)
    commands, shown = (list(dict.fromkeys(names)) for names in zip(*found.positions, strict=True))
    system = found.closed_loop[shown, commands]
    if duration is None:
        return control.step_response(system)
    periods = loop.periods(duration)
    return control.step_response(system, np.arange(periods + 1) * loop.period)


# ---- the point
class _Point:
    """States, signals and time at the operating point; the loop as it would start from there."""

    def __init__(self, loop: Loop, time: float | None, state: dict[str, float], ideal: tuple[str, ...]) -> None:
        self.ideal = ideal
        self.time = 0.0
        states = {s: loop.start_state(b) for s, b in loop.blocks.items() if b is not None and b.state is not None}
        if time is not None and time != 0.0:
            validate.positive("time", time, "s")
            live = loop.start()
            ran = live.advance(loop.periods(time), record=(), every=0).check()
            del ran
            reached = live.program.plan.state.unpack(*live.state)
            states = {s: getattr(reached, s) for s in states}
            self.time = live.time
        for key, value in state.items():
            slot, _, rest = key.partition(".")
            if slot not in states:
                raise NameUnknown(f"there is no state {key!r}{nearest(key, _keys(states))}")
            try:
                states[slot] = checked_replace(states[slot], {rest: value}, where=key)
            except NameUnknown:
                raise NameUnknown(f"there is no state {key!r}{nearest(key, _keys(states))}") from None
        self.loop = loop.using()
        self.loop.__dict__.pop("program", None)
        self.loop.__dict__["signals"] = loop.signals
        self.noise = Noise(loop.seed, 0, 0, 0)
        self._place(states)
        self.at_rest = time is None
        self.given = {key.split(".")[0] for key in state}
        self.signals = self._signals()

    def _place(self, states: Mapping[str, Any]) -> None:
        for slot, value in states.items():
            block = self.loop.blocks[slot]
            assert block is not None
            self.loop.blocks[slot] = replace(block, state=value, initial=None)

    def _signals(self) -> dict[str, Any]:
        loop = self.loop
        plant = loop.blocks["plant"]
        assert plant is not None
        command, load = self.result("reference", {}), self.result("disturbance", {})
        actual = filled(loop.signals["actual"], self.shown(plant.state))
        self._settle("sensor", {"actual": actual})
        feedback = self._passed("sensor", "feedback", "actual", actual)
        if self.at_rest:
            tree = Layout(loop.signals["command"])
            values, seen = numbers(command), numbers(feedback)
            places = [leaf.key for leaf in leaves(Layout(loop.signals["feedback"]).tree)]
            for pair in pairs(tree.tree, Layout(loop.signals["feedback"]).tree):
                values[tree.keys[pair.command].at] = seen[places.index(pair.other)]
            command = filled(loop.signals["command"], values)
        self._settle("controller", {"command": command, "feedback": feedback})
        output = self.result("controller", {"command": command, "feedback": feedback})
        self._settle("actuator", {"output": output})
        return {
            "command": command, "feedback": feedback, "output": output,
            "applied": self._passed("actuator", "applied", "output", output), "actual": actual,
            "disturbance": loop.signals["load"] if load is None else load,
        }  # fmt: skip

    def _passed(self, slot: str, signal: str, source: str, value: Any) -> Any:
        """What a sensor or actuator gives; where it is ideal, what it gets."""
        if self.loop.blocks[slot] is not None and slot not in self.ideal:
            return self.result(slot, {source: value})
        example = self.loop.signals[signal]
        same = self.same(signal, source)
        return filled(example, np.where(same.any(axis=1), same @ numbers(value), numbers(example)))

    def same(self, signal: str, source: str) -> np.ndarray:
        """Which number of a signal an ideal block takes from which number of its source: by name, or the position."""
        mine, theirs = (Layout(self.loop.signals[k]).tree for k in (signal, source))
        columns = [leaf.key for leaf in leaves(theirs)]
        found = np.zeros((len(leaves(mine)), len(columns)))
        compared = {p.command: p.other for p in pairs(mine, theirs)}
        for i, leaf in enumerate(leaves(mine)):
            key = leaf.key if leaf.key in columns else compared.get(leaf.key)
            if key is not None:
                found[i, columns.index(key)] = 1.0
        return found

    def shown(self, state: Any) -> np.ndarray:
        """The numbers that the plant shows in a state."""
        plant = self.loop.blocks["plant"]
        assert plant is not None
        shown = plant.output if plant.output is not None else plant.state._fields[0]
        if not callable(shown):
            for part in str(shown).split("."):
                state = getattr(state, part)
            return numbers(state)
        given = {"p": self.loop.prepared(plant, "plant"), "s": state}
        return numbers(shown(*(given[n] for n in shown.__code__.co_varnames[: shown.__code__.co_argcount])))

    def stepped(self, slot: str, given: Mapping[str, Any]) -> tuple[Any, Any]:
        """Next state and signal of a block at the point; none where the slot is empty or counted as ideal."""
        block = self.loop.blocks[slot]
        if block is None or slot in self.ideal:
            return None, None
        signals = {"t": self.time, "dt": self.loop.period, "noise": self.noise, **given}
        lead = [self.loop.prepared(block, slot)] if block.params is not None else []
        if block.state is None:
            return None, block.step(*lead, *(signals[n] for n in block.signals))
        own = Layout(block.state)
        following, signal = block.step(*lead, own.unpack(*own.pack(block.state)), *(signals[n] for n in block.signals))
        return following, signal

    def result(self, slot: str, given: Mapping[str, Any]) -> Any:
        """The signal that a block gives at the point."""
        return self.stepped(slot, given)[1]

    def _settle(self, slot: str, signals: Mapping[str, Any]) -> None:
        """Runs a block under constant signals until its state stays; at rest it is linearised as it is then.

        Raises:
            ValueRefused: its state counts on: no two of its periods are alike.
        """
        block = self.loop.blocks[slot]
        if block is None or block.state is None or slot in self.ideal or block.continuous:
            return
        before, counting = block.state, [""]
        counts: dict[str, float] = {}
        for _ in range(SETTLING):
            following = self.stepped(slot, signals)[0]
            layout = Layout(following)
            scalars = layout.pack(following)[0]
            last, counts = counts, {x.key: float(scalars[x.at]) for x in layout.scalars}
            self._place({slot: following})
            counting = [x.key for x in layout.scalars if x.kind != "float" and counts[x.key] != last.get(x.key)]
            if counts == last:
                break
        if not self.at_rest or slot in self.given:
            self._place({slot: before})
        if counting:
            raise ValueRefused(
                f"{block.name}: its state {counting[0]} counts on from period to period, so its periods are not alike: "
                "it has no one linear view"
            )


def _keys(states: Mapping[str, Any]) -> list[str]:
    return [f"{slot}.{leaf.key}" for slot, state in states.items() for leaf in Layout(state).scalars]


# ---- Jacobians
def _jacobian(
    f: Flat, at: np.ndarray, moved: np.ndarray, names: Sequence[str], block: Block, outputs: int
) -> np.ndarray:
    """The Jacobian at a point of ``f``, the step of a block, by central differences.

    Of the steps of a difference each number takes the one where two neighbouring ones agree best. The last ``outputs``
    numbers of ``f`` are the block's output. Columns that are not ``moved`` stay 0.

    Raises:
        ValueRefused: a jump, a kink, or a value that moves in steps.
    """
    start = f(at)
    rows = np.arange(len(start))
    jacobian = np.zeros((len(start), len(at)))
    for k in np.flatnonzero(moved).tolist():
        steps = STEPS * max(1.0, abs(at[k]))
        unit = np.zeros(len(at))
        unit[k] = 1.0
        above = np.array([f(at + h * unit) for h in steps])
        below = np.array([f(at - h * unit) for h in steps])
        h = steps[:, None]
        slopes = (above - below) / (2.0 * h)
        largest = np.abs(np.concatenate([above.ravel(), below.ravel(), at])).max()
        lost = np.broadcast_to(ROUNDING * largest / h, slopes.shape)
        cost = np.abs(np.diff(slopes, axis=0)) + lost[1:]
        for m in range(len(cost)):  # where there is a derivative, the slopes of the next smaller steps agree with it
            off = np.abs(slopes[m + 1 : m + 5] - slopes[m]) > CONVERGED * np.abs(slopes[m]) + 10.0 * lost[m + 1 : m + 5]
            cost[m, off.any(axis=0)] = np.inf
        best = np.argmin(cost, axis=0)
        jumps = np.isinf(cost[best, rows])
        slope, doubt = slopes[best, rows], 10.0 * lost[best + 1, rows]
        # the slopes of both sides: they come together as the step shrinks, but not at a kink
        apart = np.abs(above + below - 2.0 * start) / h
        bent = (apart[best, rows] > KINK * np.abs(slope) + doubt) & (apart[best + 1, rows] > 0.5 * apart[best, rows])
        # nothing moves for a small step and both ways for a larger one: at a limit one way stays
        still = (above[best, rows] == start) & (below[best, rows] == start)
        wider = (
            (above != start) & (below != start) & (np.abs(slopes) > np.maximum(lost, 0.02 * np.abs(slopes).max(axis=0)))
        )
        stepped = still & wider.any(axis=0)
        for wrong, what in ((jumps, "jumps"), (bent, "has a kink"), (stepped, "moves in steps")):
            if wrong.any():
                which = "output" if np.flatnonzero(wrong)[-1] >= len(start) - outputs else "state"
                _refuse(block, f"its {which} {what} at {names[k]} = {at[k]:g}")
        jacobian[:, k] = slope
    return jacobian


def _refuse(block: Block, what: str) -> None:
    advice = "choose another point (time=, state=)"
    if block.kind in ("sensor", "actuator"):
        advice += f" or count it as ideal (ideal=['{block.kind}'])"
    raise ValueRefused(
        f"{block.name}: {what}: a relay, a quantiser, a dead zone or a limit has no linear view; {advice}"
    )


class _Parts:
    """The Jacobians of the blocks at a point, and the loop that they make."""

    def __init__(self, point: _Point) -> None:
        self.point, self.loop = point, point.loop
        signals = point.signals
        self.names: list[str] = []
        self.widths = {k: len(numbers(v)) for k, v in signals.items()}
        self.orders = {s: 0 if s in point.ideal else _order(b) for s, b in self.loop.blocks.items()}
        self.plant = self._of("plant", ("applied", "disturbance"))
        self.shown = self._shown()
        self.sensor = self._of("sensor", ("actual",))
        self.controller = self._of("controller", ("command", "feedback"))
        self.actuator = self._of("actuator", ("output",))
        self.inputs = [_plain(n) for n in (*self._labels("command"), *self._labels("disturbance"))]
        self.outputs = [_plain(n) for n in (*self._labels("actual"), *self._labels("output"))]

    def _labels(self, signal: str) -> list[str]:
        return [under(signal, leaf.key) for leaf in leaves(Layout(self.point.signals[signal]).tree)]

    def _of(self, slot: str, takes: tuple[str, ...]) -> np.ndarray:
        """``[[A, B], [C, D]]`` of a block."""
        point, block = self.point, self.loop.blocks[slot]
        if block is None or slot in point.ideal:
            return point.same(*(("feedback", "actual") if slot == "sensor" else ("applied", "output")))
        at = np.concatenate([numbers(point.signals[k]) for k in takes])
        ends = np.cumsum([self.widths[k] for k in takes])[:-1]

        def given(u: np.ndarray) -> dict[str, Any]:
            parts = dict(zip(takes, np.split(at + u, ends), strict=True))
            values = {k: filled(point.signals[k], v) for k, v in parts.items()}
            if slot == "plant":
                load = values["disturbance"]
                u_ = values["applied"] if "load" in block.signals else _added(values["applied"], load)
                return {"u": u_, "load": load}
            return values

        step, order, rest = flat_step(self.loop, slot, given, point.time)
        own = Layout(block.state) if block.state is not None else None
        labels = [] if own is None else [leaf.key for leaf in own.scalars]
        labels += [] if own is None else [f"{leaf.key}[{i}]" for leaf in own.arrays for i in range(leaf.size)]
        kinds = [] if own is None else [leaf.kind == "float" for leaf in own.scalars]
        kinds += [True] * (order - len(kinds))
        self.names += [f"{slot}.{n}" for n in labels]
        try:
            exact = Linear(step, order, len(at), rest)
            if exact.linear():
                exact.whole[:, [k for k, number in enumerate(kinds) if not number]] = 0.0
                return exact.whole
        except (ArithmeticError, ValueError, IndexError):
            pass  # no step for the large unit of an exact difference: the small ones below say what is wrong
        names = [*(f"{slot}.{n}" for n in labels), *(n for k in takes for n in self._labels(k))]
        whole = np.concatenate([rest, at])
        try:
            return _jacobian(
                lambda z: np.concatenate(step(z[:order], z[order:] - at)), whole,
                np.array([*kinds, *[True] * len(at)]), names, block,
                0 if slot == "plant" else self.widths["output" if slot == "controller" else "feedback"],
            )  # fmt: skip
        except (ArithmeticError, ValueError) as error:
            if isinstance(error, ValueRefused):
                raise
            what = f"{type(error).__name__}: {error}"
            raise ValueRefused(f"{block.name}: its step fails near the point: {what}") from error

    def _shown(self) -> np.ndarray:
        """What the plant shows, as rows on its state."""
        block = self.loop.blocks["plant"]
        assert block is not None
        own = Layout(block.state)
        scalars, arrays = own.pack(block.state)
        count = len(own.scalars)
        rest = np.concatenate([scalars[:count], arrays[: own.array_size]])

        def read(x: np.ndarray) -> np.ndarray:
            held = x[:count] if count else np.zeros(1)
            return self.point.shown(own.unpack(held, x[count:] if own.array_size else np.zeros(1)))

        moved = np.array([leaf.kind == "float" for leaf in own.scalars] + [True] * own.array_size)
        names = [f"plant.{leaf.key}" for leaf in own.scalars] + [f"plant state {i}" for i in range(own.array_size)]
        return _jacobian(read, rest, moved, names, block, len(read(rest)))

    def refuse_cut(self) -> None:
        """Names the block through which nothing passes.

        Raises:
            ValueRefused: always.
        """
        for slot, part, signal in (("controller", self.controller, "error"), ("actuator", self.actuator, "output"),
                                   ("plant", self.plant, "input"), ("sensor", self.sensor, "actual")):  # fmt: skip
            block = self.loop.blocks[slot]
            if block is None:
                continue
            entering = part[:, self.orders[slot] :]
            if slot == "controller":
                entering = entering[:, self.widths["command"] :]
            if slot == "plant":
                entering = entering[:, : self.widths["applied"]]
            if not entering.any():
                _refuse(block, f"does not answer its {signal} at this point, so there is no loop")
        raise ValueRefused(f"{self.loop.name}: the error does not reach the feedback: there is no loop to look at")

    def joined(self, cut: Sequence[str] | None) -> tuple[np.ndarray, ...]:
        """The loop over one period, closed; or cut at these numbers of the feedback, then minus the errors."""
        loop, widths = self.loop, self.widths
        at = [0, *np.cumsum([self.orders[s] for s in ("plant", "sensor", "controller", "actuator")])]
        sent, sent_part = divmod(loop.sent, loop.substeps)
        seen, seen_part = divmod(loop.seen, loop.substeps)
        sent_line, seen_line = sent + (sent_part > 0), seen + (seen_part > 0)
        nu, ny = widths["applied"], widths["actual"]
        line = int(at[-1])
        late = line + sent_line * nu
        order = late + seen_line * ny
        width = len(cut) if cut is not None else widths["command"] + widths["disturbance"]
        state = np.eye(order, order + width)
        given = np.eye(width, order + width, order)
        none = np.zeros((widths["command"] + widths["disturbance"], order + width))
        external = given if cut is None else none
        command, load = external[: widths["command"]], external[widths["command"] :]
        moved = np.zeros((order, order + width))
        x = state[: at[1]]
        actual = self.shown @ x
        past = [actual, *(state[late + i * ny : late + (i + 1) * ny] for i in range(seen_line))]
        delayed = past[seen + 1] if seen_part else past[seen]
        feedback, moved[at[1] : at[2]] = _through(self.sensor, state[at[1] : at[2]], delayed)
        if cut is not None:
            places = [leaf.key for leaf in leaves(Layout(self.point.signals["feedback"]).tree)]
            cuts = [places.index(key) for key in cut]
            back, feedback = feedback[cuts], feedback.copy()
            feedback[cuts] = -given
        output, moved[at[2] : at[3]] = _through(
            self.controller, state[at[2] : at[3]], np.concatenate([command, feedback])
        )
        applied, moved[at[3] : at[4]] = _through(self.actuator, state[at[3] : at[4]], output)
        held = [applied, *(state[line + i * nu : line + (i + 1) * nu] for i in range(sent_line))]
        for i in range(sent_line):
            moved[line + i * nu : line + (i + 1) * nu] = held[i]
        for i in range(1 if seen_part else 0, seen_line):
            moved[late + i * ny : late + (i + 1) * ny] = past[i]
        a, b = self._plant_step()
        if loop.continuous:
            moved[: at[1]] = a @ x + b @ np.concatenate([applied, load])
        else:
            stops = sorted({0, sent_part, loop.substeps - seen_part, loop.substeps})
            for start, stop in pairwise(stops):
                u = held[sent + 1] if start < sent_part else held[sent]
                ah, bh = _held(a, b, stop - start)
                x = ah @ x + bh @ np.concatenate([u, load])
                if seen_part and stop == loop.substeps - seen_part:
                    moved[late : late + ny] = self.shown @ x
            moved[: at[1]] = x
        rows = back if cut is not None else np.concatenate([actual, output])
        return moved[:, :order], moved[:, order:], rows[:, :order], rows[:, order:]

    def _plant_step(self) -> tuple[np.ndarray, np.ndarray]:
        """The plant over one integration step, or its derivative in a continuous loop."""
        block = self.loop.blocks["plant"]
        assert block is not None
        order = self.orders["plant"]
        a, b = self.plant[:, :order], self.plant[:, order:]
        if self.loop.continuous or "dt" in block.signals:
            return a, b
        moved = [hold_matrices(a, b[:, j], self.loop.step) for j in range(b.shape[1])]
        return moved[0][0], np.column_stack([drive for _, drive in moved])


def _plain(name: str) -> str:
    """A dotted name as python-control takes it: ``command_position``."""
    return name.replace(".", "_")


def _added(u: Any, load: Any) -> Any:
    """The plant's input with the load added: number by number, or a single one to the first."""
    values, more = numbers(u), numbers(load)
    values[: len(more)] += more
    return filled(u, values)


def _order(block: Block | None) -> int:
    """How many numbers a block's state has."""
    if block is None or block.state is None:
        return 0
    own = Layout(block.state)
    return len(own.scalars) + own.array_size


def _through(block: np.ndarray, state: np.ndarray, given: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What a block puts out, and its next state."""
    order = len(state)
    whole = block @ np.concatenate([state, given])
    return whole[order:], whole[:order]


def _held(a: np.ndarray, b: np.ndarray, steps: int) -> tuple[np.ndarray, np.ndarray]:
    """``steps`` integration steps under constant inputs."""
    order, inputs = b.shape
    one = np.block([[a, b], [np.zeros((inputs, order)), np.eye(inputs)]])
    whole = np.linalg.matrix_power(one, steps)
    return whole[:order, :order], whole[:order, order:]


def _without_constants(
    a: np.ndarray, b: np.ndarray, c: np.ndarray, sampled: bool
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The system without what keeps its value and is not reached by the input, or not shown by the output.

    A bristle at rest moves with its axis, so the difference of the two is such a constant: no pole of the loop.
    """
    from scipy.linalg import matrix_balance, null_space

    if not len(a):
        return a, b, c
    scale = np.diag(matrix_balance(a, permute=False)[1])
    small = a / scale[:, None] * scale, b / scale[:, None], c * scale
    for dual in (False, True):
        x, y, z = (small[0].T, small[2].T, small[1].T) if dual else small
        still = (np.eye(len(x)) if sampled else 0.0) - x
        constant = null_space(np.hstack([still, y / (np.linalg.norm(y) or 1.0)]).T, rcond=CONSTANT)
        if constant.shape[1]:
            kept = null_space(constant.T)
            x, y, z = kept.T @ x @ kept, kept.T @ y, z @ kept
            small = (x.T, z.T, y.T) if dual else (x, y, z)
    return small if len(small[0]) < len(a) else (a, b, c)


def _minimal(
    a: np.ndarray, b: np.ndarray, c: np.ndarray, names: Sequence[str]
) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[str]]:
    """The states that the inputs reach and the outputs show, by which entries are zero; and their names."""
    reached, shown = b.any(axis=1), c.any(axis=0)
    for _ in range(len(a)):
        reached = reached | ((a != 0.0) @ reached)
        shown = shown | (shown @ (a != 0.0))
    kept = reached & shown
    every = [*names, *(f"delayed[{i}]" for i in range(len(a) - len(names)))]
    return a[np.ix_(kept, kept)], b[kept], c[:, kept], [_plain(every[k]) for k in np.flatnonzero(kept).tolist()]


__all__ = ["Linearization", "linearize", "margins", "step_response"]
