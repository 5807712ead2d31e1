"""Public names of a package, in its ``__init__.pyi``: each loads its own module when it is first used."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

import lazy_loader

from leadscrew.util.frames import trimmed


def exports(package: str, file: str) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """``__getattr__``, ``__dir__`` and ``__all__`` of a package; Python suggests a name for one that is misspelt."""
    load, names, public = lazy_loader.attach_stub(package, file)

    def get(name: str) -> Any:
        if name not in public:
            raise AttributeError(f"module {package!r} has no attribute {name!r}", name=name, obj=sys.modules[package])
        return load(name)

    return trimmed(get, AttributeError), names, public
