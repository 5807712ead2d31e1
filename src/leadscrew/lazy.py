"""Public names of a package that load what they need when they are first used."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any

from leadscrew.frames import trimmed


def doors(space: dict[str, Any], homes: Mapping[str, str]) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """``__getattr__`` and ``__dir__`` of the package with these globals; ``homes`` has the names of each module.

    ``__getattr__`` raises AttributeError where there is no such name.
    """
    package = space["__name__"]
    found = {name: home for home, names in homes.items() for name in names.split()}

    def get(name: str) -> Any:
        if name not in found:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        space[name] = getattr(import_module(f"{package}.{found[name]}"), name)
        return space[name]

    return trimmed(get, AttributeError), lambda: sorted({*space, *found})
