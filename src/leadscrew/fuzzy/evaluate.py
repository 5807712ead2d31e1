"""Evaluates a fuzzy system from Python: at a point, or at many.

A NaN among the inputs that the rules ask for gives NaN, never the default. Infinite inputs are far to the left or
right. Where no rule fires an output takes its last value (``lock_previous``), else its default (NaN unless it is
given). An output whose aggregated set has no area (rules fire, but their sets lie outside its universe) is NaN.
A disabled output is NaN.
"""

from __future__ import annotations

import ctypes
import struct
import threading
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

import numpy as np

from leadscrew.fuzzy.engine import Engine, engine, execute
from leadscrew.fuzzy.system import System
from leadscrew.fuzzy.tables import is_exact, is_integral
from leadscrew.kernel.bits import stack_array2
from leadscrew.kernel.engines import Entry, by_python, check_engine, native
from leadscrew.kernel.module import Module
from leadscrew.kernel.parameters import nearest
from leadscrew.util.errors import NameUnknown, ValueRefused, entry_point

LANES = 16
"""Points whose rules are worked out side by side."""


def entries(made: Engine) -> tuple[str, dict[str, Any]]:
    """Source of the two entries: ``one`` point and ``many``."""
    w, system = made.writer, made.system
    outputs = [w.names[o.name] for o in system.outputs]
    ins, outs = len(w.inputs), len(outputs)
    lasts = {o.name: f"V[{ins + k}]" for k, o in enumerate(system.outputs)}
    given = ", ".join(["p", *(f"V[{i}]" for i in range(ins)), *(lasts[n] for n in made.locked)])
    lines = ["def one(V):", plan_views("V", ins + outs, made), f"    {', '.join(outputs)} = infer({given})"]
    lines += [f"    V[{ins + k}] = {name}" for k, name in enumerate(outputs)]
    lines += ["    return 0", "", "", "def many(A, X, Y, span):", plan_views("A", 0, made)]
    lines += [f"    {w.last(o)} = NAN" for o in w.live if o.lock_previous]
    lanes = any(is_integral(o) or is_exact(o) for o in w.live)
    lines += _lanes(made) if lanes else _line(made)
    return "\n".join([*lines, "    return 0"]) + "\n", {"stack_array2": stack_array2}


def plan_views(vector: str, at: int, made: Engine) -> str:
    """The plan as views of one vector."""
    views = []
    for array in made.plan:
        view = f"{vector}[{at}:{at + array.size}]"
        views.append(view if array.ndim == 1 else f"{view}.reshape({', '.join(map(str, array.shape))})")
        at += array.size
    return f"    p = Plan({', '.join(views)})"


def _line(made: Engine) -> list[str]:
    """Points one by one, in a form that vectorises."""
    w = made.writer
    inputs = ", ".join(["p", *(f"X[{i}, k]" for i in range(len(w.inputs)))])
    last = [w.last(o) for o in w.live if o.lock_previous]
    outputs = [w.names[o.name] for o in made.system.outputs]
    lines = ["    for k in range(span[0], span[1]):"]
    lines.append(f"        {', '.join(outputs)} = infer({', '.join([inputs, *last])})")
    for k, o in enumerate(made.system.outputs):
        lines.append(f"        Y[{k}, k] = {outputs[k]}")
        if o.enabled and o.lock_previous:
            lines.append(f"        {w.last(o)} = {outputs[k]}")
    return lines


def _lanes(made: Engine) -> list[str]:
    """Rules of several points side by side, then their outputs one by one."""
    w = made.writer
    groups = [(o, i) for o in w.live for i in range(w.width(o))]
    names = [f"g{n}" for n in range(len(groups))]
    points = ", ".join(["p", *(f"X[{i}, base + lane]" for i in range(len(w.inputs)))])
    lines = [
        f"    G = stack_array2({max(1, len(groups))}, {LANES})",
        f"    for base in range(span[0], span[1], {LANES}):",
        f"        for lane in range({LANES}):",
        f"            {', '.join(names) or 'g0'} = degrees({points})",
        *(f"            G[{n}, lane] = g{n}" for n in range(len(groups))),
        f"        for lane in range({LANES}):",
    ]
    for k, output in enumerate(made.system.outputs):
        if not output.enabled:
            lines.append(f"            Y[{k}, base + lane] = NAN")
            continue
        mine = [f"G[{n}, lane]" for n, (o, _) in enumerate(groups) if o is output]
        last = [w.last(output)] if output.lock_previous else []
        name = w.names[output.name]
        lines.append(f"            {name} = {name}_value({', '.join([points, *mine, *last])})")
        lines.append(f"            Y[{k}, base + lane] = {name}")
        lines += [f"            {x} = {name}" for x in last]
    return lines


RANKS = {"A": (1, "f"), "V": (1, "f"), "X": (2, "f"), "Y": (2, "f"), "span": (1, "i")}
"""Dimensions and element (``f`` float, ``i`` integer) of what the entries take."""


@entry_point
class Compiled:
    """A system as machine code; made by :func:`compiled`."""

    def __init__(self, made: Engine, name: str = "llvm") -> None:
        self.made, self.engine = made, name
        self.inputs = [v.name for v in made.system.inputs]
        self.outputs = [v.name for v in made.system.outputs]
        self._named = set(self.inputs)
        text, extra = entries(made)
        space = {**made.space, **extra, "Plan": made.plan_type}
        self._functions = execute(text, f"{made.system.name} entries", space)
        self._plan = np.concatenate([np.ravel(a) for a in made.plan])
        ins, outs = len(self.inputs), len(self.outputs)
        self._vector = np.concatenate([np.zeros(ins), np.full(outs, np.nan), self._plan])
        self.scalar = self._scalar()
        self._many: Any = None

    # ---- entries
    def _entry(self, name: str) -> Callable[..., Any]:
        check_engine(self.engine)
        module = Module()
        for part in ("degrees", "infer"):
            module.function(self._functions[part], trusted=False)
        module.entry(self._functions[name], name)
        if self.engine == "python":
            return by_python(module.namespace()[name])
        return native(module, name, self.engine, f"fuzzy_{module.identity()}_{name}", RANKS)

    def _bound(self, entry: Any, *arrays: np.ndarray) -> Callable[[], Any]:
        if hasattr(entry, "bind"):
            bound: Callable[[], Any] = entry.bind(*arrays)
            return bound
        return lambda: entry(*arrays)

    # ---- a point
    def _scalar(self) -> Callable[..., Any]:
        """The function behind ``scalar``, with everything that it needs at hand: half the time of a call is Python."""
        ins, outs = len(self.inputs), len(self.outputs)
        buffer, lock, start = self._vector.data.cast("B"), threading.Lock(), 8 * ins
        pack, unpack = struct.Struct(f"={ins}d").pack_into, struct.Struct(f"={outs}d").unpack_from
        entry = self._entry("one")
        call = self._bound(entry, self._vector)
        if isinstance(entry, Entry):
            vector = (ctypes.c_void_p(self._vector.ctypes.data), ctypes.c_int64(self._vector.size))
            call = partial(entry.function, *vector)

        def scalar(*values: float) -> Any:
            """The output at a point, inputs in the order of the system; a tuple where there are several outputs."""
            if len(values) != ins:
                raise ValueRefused(f"{len(values)} values for the inputs {', '.join(self.inputs)}")
            with lock:
                pack(buffer, 0, *values)
                call()
                out = unpack(buffer, start)
            return out[0] if outs == 1 else out

        return scalar

    def __call__(self, **values: float) -> dict[str, float]:
        """All outputs by name, inputs by name."""
        if len(values) != len(self.inputs) or not values.keys() <= self._named:
            self._known(values)
        found = self.scalar(*[values[n] for n in self.inputs])
        return dict(zip(self.outputs, found if isinstance(found, tuple) else (found,), strict=True))

    def restart(self) -> None:
        """Forgets the last outputs, which ``lock_previous`` keeps."""
        self._vector[len(self.inputs) : len(self.inputs) + len(self.outputs)] = np.nan

    def _known(self, values: Mapping[str, Any]) -> Sequence[str]:
        for name in values:
            if name not in self.inputs:
                raise NameUnknown(f"system {self.made.system.name} has no input {name!r}{nearest(name, self.inputs)}")
        missing = [n for n in self.inputs if n not in values]
        if missing:
            raise ValueRefused(f"system {self.made.system.name}: no value for the input {', '.join(missing)}")
        return self.inputs

    # ---- many points
    def many(self, points: Any = None, *, threads: int = 1, **named: Any) -> np.ndarray:
        """Outputs at many points.

        ``points`` holds one row a point and one column an input; or every input is given by name, as arrays that go
        together by NumPy's rules. Gives one column an output, in the shape of the named arrays with one axis more; of
        a system with one output that axis is left out. Outputs that keep their last value go through the points in
        order, on one thread.

        Raises:
            ValueRefused: points of another shape, or an input without values.
            NameUnknown: there is no such input.
        """
        x, shape = self._gathered(points, named)
        count = x.shape[1]
        blocks = -(-count // LANES)
        x = np.pad(x, [(0, 0), (0, blocks * LANES - count)])
        y = np.empty((len(self.outputs), x.shape[1]))
        self._many = self._many or self._entry("many")
        parts = 1 if self.made.locked else max(1, min(int(threads), blocks))
        ends = [blocks * i // parts * LANES for i in range(parts + 1)]
        jobs = [self._bound(self._many, self._plan, x, y, np.array(ends[i : i + 2])) for i in range(parts)]
        if parts == 1:
            jobs[0]()
        else:
            with ThreadPoolExecutor(parts) as pool:
                list(pool.map(lambda job: job(), jobs))
        y = y[:, :count]
        return y[0].reshape(shape) if len(y) == 1 else np.ascontiguousarray(y.T).reshape(*shape, len(y))

    def _gathered(self, points: Any, named: Mapping[str, Any]) -> tuple[np.ndarray, tuple[int, ...]]:
        if points is None:
            arrays = np.broadcast_arrays(*(np.asarray(named[n], dtype=float) for n in self._known(named)))
            return np.ascontiguousarray([a.ravel() for a in arrays]), arrays[0].shape
        rows = np.asarray(points, dtype=float)
        if named or rows.ndim != 2 or rows.shape[1] != len(self.inputs):
            raise ValueRefused(
                f"points of shape {rows.shape}: expected one row a point and the columns {', '.join(self.inputs)}"
            )
        return np.ascontiguousarray(rows.T), rows.shape[:1]


@entry_point
def compiled(system: System, engine_name: str = "llvm") -> Compiled:
    """A system ready to be evaluated from Python, on one of the engines llvm, c, python.

    Raises:
        ValueRefused: something that cannot be evaluated; says what.
    """
    return Compiled(engine(system), engine_name)
