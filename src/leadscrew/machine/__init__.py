"""A machine in a file: what was identified of an axis, as a study that every command takes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from leadscrew.lazy import doors

if TYPE_CHECKING:
    from leadscrew.machine.axis_study import study
    from leadscrew.machine.file import MachineFile, read, write
    from leadscrew.machine.from_fit import from_axis, from_linear

__all__ = ["MachineFile", "from_axis", "from_linear", "read", "study", "write"]

__getattr__, __dir__ = doors(
    globals(), {"file": "MachineFile read write", "from_fit": "from_axis from_linear", "axis_study": "study"}
)
