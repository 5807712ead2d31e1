"""The rest of the loop in C: reference, sensor, actuator, disturbances and plant, to close the loop around an export.

With it a machine can be simulated where the controller will run. It is the same arithmetic as in the loop, so the loop
closed in HAL gives the bits of the loop simulated here.
"""

from __future__ import annotations

import ast
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from leadscrew.export import hal
from leadscrew.export.core import Core
from leadscrew.export.machine import LICENCE
from leadscrew.export.source import argument_name
from leadscrew.export.templates import render
from leadscrew.kernel.c99.prelude import GUARD
from leadscrew.kernel.c99.translation import Translation, entry_function
from leadscrew.kernel.linker import Linker
from leadscrew.kernel.module import Module
from leadscrew.kernel.program import RANKS

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop


@dataclass(frozen=True)
class Pin:
    """One number between the simulated machine and the controller."""

    key: str
    name: str
    at: int
    """Its place in ``X``."""
    unit: str

    @property
    def hal(self) -> str:
        """Its name in HAL."""
        return self.name.replace("_", "-")


def pin(core: Core, signal: str, leaf: str, at: int) -> Pin:
    """The pin of one number of a signal."""
    key = f"{signal}.{leaf}" if leaf else signal
    units = {p.key: p.unit for p in (*core.inputs, *core.outputs)}
    return Pin(key, argument_name(key), at, units.get(key, ""))


def plant_files(loop: Loop, core: Core) -> dict[str, str]:
    """``NAME_plant.{h,c}``, the HAL component ``NAME_plant.comp``, and ``NAME_loop.hal``, which closes the loop.

    Raises:
        ValueRefused: a name is too long for HAL.
    """
    module = Module()
    plan = loop.program.plan
    held = Linker(plan, module).split()
    unit = Translation(module)
    title = f"{core.name}_plant"
    bodies = []
    for entry in ("read", "write"):
        node = module.items[entry].node
        assert isinstance(node, ast.FunctionDef)
        bodies.append(entry_function(unit, node, RANKS["split"], f"static int64_t {entry}_period"))
    params, state = loop.values()
    vectors = {"P": plan.params.pack(params)[0], "A": plan.params.pack(params)[1],
               "S": plan.state.pack(state)[0], "B": plan.state.pack(state)[1]}  # fmt: skip
    pins = [pin(core, s, x.key, i) for i, (s, x) in enumerate(held) if s != "load"]
    hal.check_lengths(title, [*(p.hal for p in pins), "write.tmax-increased"])
    ours = {p.name: name for side in (core.inputs, core.outputs)
            for p, name in zip(side, hal.pins((q.name, q.role) for q in side), strict=True)}  # fmt: skip
    values = {
        "core": core,
        "n": title,
        "comp": hal.component(title),
        "own": hal.component(core.name),
        "licence": LICENCE,
        "loop": loop.name,
        "vectors": {k: [number(x) for x in v.tolist()] for k, v in vectors.items()},
        "held": len(held),
        "shown": [p for p in pins if not p.key.startswith("output")],
        "taken": [p for p in pins if p.key.startswith("output")],
        "wires": [(p.hal, ours[p.name]) for p in pins if not p.key.startswith("output") and p.name in ours],
        "back": [(p.hal, ours[p.name]) for p in pins if p.key.startswith("output")],
        "nanoseconds": round(core.period * 1e9),
        "seconds": 4,
    }
    source = "\n".join(
        [render("plant_head.c.j2", **values), unit.includes("float.h"), GUARD, unit.text(), *bodies,
         render("plant_tail.c.j2", **values)]
    )  # fmt: skip
    return {
        f"{title}.h": render("plant.h.j2", **values),
        f"{title}.c": source,
        f"{title}_hal.h": render("hal_plant_header.j2", **values),
        f"{title}.comp": render("hal_plant.j2", **values),
        f"{core.name}_loop.hal": render("hal_loop.j2", **values),
    }


def number(value: float) -> str:
    """A double as C source."""
    return repr(value) if np.isfinite(value) else "NAN" if np.isnan(value) else "INFINITY" if value > 0 else "-INFINITY"
