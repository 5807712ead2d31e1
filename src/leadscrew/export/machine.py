"""The machine layer in C: enable, signs, limits and faults around the controller's own step."""

from __future__ import annotations

from leadscrew.export.core import Core, Port
from leadscrew.export.templates import render

LICENCE = """\
 * Exported code belongs to whoever exported it. The parts that come from Leadscrew (the ls_ functions and the machine
 * layer) are under the BSD 3-clause licence; the README beside this file has its text."""


def number(value: float, real: str) -> str:
    """A number as C source, exactly."""
    text = repr(float(value))
    return f"{text}f" if real == "float" else text


def machine_files(core: Core) -> dict[str, str]:
    """``NAME_machine.h`` and ``NAME_machine.c``."""

    def of(role: str) -> Port | None:
        return next((i for i in core.inputs if i.role == role), None)

    names = {
        "core": core,
        "n": core.name,
        "real": core.real,
        "licence": LICENCE,
        "largest": "FLT_MAX" if core.real == "float" else "DBL_MAX",
        "args": ", ".join(f"{core.real} {i.name}" for i in core.inputs),
        "names": ", ".join(i.name for i in core.inputs),
        "out": core.outputs[0].name,
        "command": of("command"),
        "feedback": of("feedback"),
        "deriv": of("command-deriv"),
        "accel": of("command-accel"),
        "number": lambda x: number(x, core.real),
        "unit": lambda port: f", {port.unit}" if port.unit else "",
    }
    return {f"{core.name}_machine.{end}": render(f"machine.{end}.j2", **names) for end in ("h", "c")}
