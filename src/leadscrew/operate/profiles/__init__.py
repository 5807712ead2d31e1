"""How each machine is operated, one file a study; :mod:`~leadscrew.operate.profiles.general` for every other one."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from leadscrew.operate.profile import Profile

OWN = ("vud_lathe", "grey_turning", "fsmc_ballscrew", "sofnn_tangent", "npid_xytable")
"""Studies that have a profile of their own."""


def profile_of(name: str) -> Profile:
    """The profile of a study by its name, or of a machine file, ``path/file.py:name`` or plug-in.

    Raises:
        NameUnknown, DataError: there is no such study; the file cannot be read.
    """
    if name in OWN:
        found: Profile = import_module(f"leadscrew.operate.profiles.{name}").PROFILE
        return found
    from leadscrew.operate.profiles.general import profile

    return profile(name)
