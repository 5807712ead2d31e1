"""The engines: an entry of a generated module, run by each of them with the same bits."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.frames import warning_level
from leadscrew.kernel.errors import ValueRefused

if TYPE_CHECKING:
    from leadscrew.kernel.module import Module
    from leadscrew.kernel.native import Entry

ENGINES = ("llvm", "c", "python")
"""The engines, the fastest to start first."""


def check_engine(engine: str) -> None:
    """Refuses what is no engine.

    Raises:
        ValueRefused: names the ones there are.
    """
    if engine not in ENGINES:
        raise ValueRefused(f"engine = {engine!r}: there are {', '.join(ENGINES)}")


def without_numba(engine: Any) -> Any:
    """The engine that a file names; ``llvm`` in place of ``numba``, which version 0.1.0 had, with a warning."""
    if engine != "numba":
        return engine
    text = "engine = 'numba': this engine was removed; 'llvm' runs instead and gives the same bits"
    warnings.warn(text, stacklevel=warning_level())
    return "llvm"


def native(module: Module, name: str, engine: str, title: str, ranks: Mapping[str, tuple[int, str]]) -> Entry:
    """An entry as machine code: from our own lowering, or from C and the machine's compiler; kept in the cache.

    ``title`` identifies the module and the entry there, ``ranks`` says what arrays the entry takes.

    Raises:
        EngineError: the engine ``c`` without a C compiler.
    """
    compiled: Callable[..., Entry]
    if engine == "c":
        from leadscrew.kernel.compiler import compiled
    else:
        from leadscrew.kernel.native import compiled
    return compiled(module, name, title, ranks)


def by_python(function: Callable[..., Any]) -> Callable[..., Any]:
    """A function of the module's own text; overflow and the like give infinity and NaN, and no warning."""

    def quiet(*args: Any) -> Any:
        with np.errstate(all="ignore"):
            return function(*args)

    return quiet
