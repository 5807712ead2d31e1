"""What every export target is made from: a controller as C99, its ports, its knobs, and a recorded run to check it by.

The C names that a target may count on, with NAME the core's ``name`` and REAL its ``real``:

- ``NAME.h``, ``NAME.c``: ``NAME_params``, ``NAME_state``, ``NAME_defaults(params)``, ``NAME_start(params, state)``,
  ``NAME_step(params, state, inputs...)`` in the paper's own signs and units;
- ``NAME_machine.h``, ``NAME_machine.c``: ``NAME_machine``, ``NAME_machine_init(m)``,
  ``NAME_machine_step(m, enable, index_enable, inputs...)`` with one argument of type REAL for each of ``inputs``, in
  order. Results are fields of ``m``: one of each of ``outputs`` by name, ``error``, ``saturated``, ``enabled``,
  ``fault`` (a ``NAME_fault``). Limits are fields: ``max_output``, ``max_error``, ``max_wrong_way``; 0 means none.
  ``derive_command_deriv`` and ``derive_command_accel`` (fields where such inputs exist) make the machine layer
  differentiate the command itself.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Port:
    """One number that goes into or comes out of a controller."""

    key: str
    """Dotted name in the loop: ``command``, ``command.velocity``, ``feedback``, ``output``."""
    name: str
    """C identifier: the argument of ``NAME_step`` or the field of ``NAME_machine``."""
    role: str
    """``command``, ``command-deriv``, ``command-accel``, ``feedback``, ``output`` or ``other``."""
    unit: str = ""
    doc: str = ""
    start: float = 0.0
    """What an input holds while nothing is connected to it."""


@dataclass(frozen=True)
class Knob:
    """A parameter of the controller that can be changed on the machine."""

    key: str
    """Dotted key among the controller's parameters."""
    name: str
    """C identifier, unique among the knobs."""
    kind: str
    """``float``, ``int``, ``bool`` or ``choice``."""
    value: float | int | bool
    """Of a choice the number."""
    places: tuple[str, ...]
    """Where it lies in C, below ``params.``: usually one place."""
    unit: str = ""
    doc: str = ""
    low: float = -np.inf
    high: float = np.inf
    range: str = ""
    """The allowed range in interval notation, open ends included; of a choice its numbers and names."""
    names: tuple[str, ...] = ()
    """Of a choice, from 0."""

    @property
    def shown(self) -> str:
        """Its value in words."""
        return f"{self.value} ({self.names[int(self.value)]})" if self.names else str(self.value).lower()


@dataclass(frozen=True)
class Limits:
    """What the machine layer watches; 0 means no limit. In the units of output and feedback."""

    max_output: float = 0.0
    max_error: float = 0.0
    max_wrong_way: float = 0.0


@dataclass(frozen=True)
class Record:
    """A recorded run of the controller: what went in, what came out, period by period from the start."""

    inputs: np.ndarray
    """Rows by period, columns as ``Core.inputs``."""
    outputs: np.ndarray
    """Rows by period, columns as ``Core.outputs``: what ``NAME_step`` gives."""


@dataclass(frozen=True)
class Core:
    """A controller as C99."""

    name: str
    """C identifier, stem of the file names."""
    title: str
    """The controller's name in the study: ``corrected.vud_beta_e``."""
    doc: str
    real: str
    """``double`` or ``float``."""
    period: float
    """Control period in seconds."""
    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...]
    knobs: tuple[Knob, ...]
    baked: tuple[str, ...]
    """Keys of parameters that are worked into others at export and cannot be changed on the machine."""
    limits: Limits
    sense: int
    """+1, or -1 where a positive output of the controller moves the axis towards negative feedback."""
    drive: str
    """What the output commands: torque, velocity, voltage, duty, position; empty where the block does not say."""
    full_scale: float
    """Size of the output at full drive; 0 where the block does not say."""
    bumpless: bool
    """Whether the controller is aligned when it is enabled, rather than started from its start state."""
    files: dict[str, str] = field(default_factory=dict)
    """The C files by name: ``NAME.h``, ``NAME.c``, ``NAME_machine.h``, ``NAME_machine.c``."""
    manifest: dict[str, Any] = field(default_factory=dict)
    """What goes into ``manifest.json`` whatever the target."""

    def machine_outputs(self, record: Record) -> np.ndarray:
        """What the machine layer gives for a record: signs turned, held to ``max_output``; enabled, without a fault."""
        return at_the_machine(record.outputs, self.sense, self.limits.max_output, self.real)


def at_the_machine(outputs: np.ndarray, sense: int, max_output: float, real: str) -> np.ndarray:
    """A controller's outputs as the machine layer gives them: signs turned, held to ``max_output``; no fault."""
    turned = outputs * sense if sense != 1 else outputs
    most = float(np.float32(max_output)) if real == "float" else max_output
    return np.ascontiguousarray(np.clip(turned, -most, most) if most > 0.0 else turned)


def expected_outputs(manifest: Mapping[str, Any], outputs: np.ndarray) -> np.ndarray:
    """What the machine layer of an export gives for golden outputs."""
    return at_the_machine(outputs, manifest["sense"], float(manifest["limits"]["max_output"]), manifest["real"])
