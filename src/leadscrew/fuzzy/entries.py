"""Writes the entries by which Python calls a fuzzy system: one point, and many."""

from __future__ import annotations

from typing import Any

from leadscrew.fuzzy.engine import Engine
from leadscrew.fuzzy.tables import is_exact, is_integral
from leadscrew.kernel.bits import stack_array2

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
