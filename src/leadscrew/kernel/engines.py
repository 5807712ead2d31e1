"""The engines: an entry of a generated module, run by each of them with the same bits."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.kernel import cache
from leadscrew.kernel.errors import ValueRefused

if TYPE_CHECKING:
    from leadscrew.kernel.module import Module
    from leadscrew.kernel.native import Entry

ENGINES = ("llvm", "c", "numba", "python")
"""The engines, the fastest to start first."""


def check_engine(engine: str) -> None:
    """Refuses what is no engine.

    Raises:
        ValueRefused: names the ones there are.
    """
    if engine not in ENGINES:
        raise ValueRefused(f"engine = {engine!r}: there are {', '.join(ENGINES)}")


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


def by_numba(module: Module, name: str) -> Callable[..., Any]:
    """An entry compiled by Numba."""
    text = module.text(name)
    title = cache.module_name(text)
    if title not in sys.modules:
        spec = importlib.util.spec_from_file_location(title, cache.store(text))
        assert spec is not None and spec.loader is not None
        made = importlib.util.module_from_spec(spec)
        sys.modules[title] = made
        spec.loader.exec_module(made)
    found: Callable[..., Any] = getattr(sys.modules[title], name)
    return found


def by_python(function: Callable[..., Any]) -> Callable[..., Any]:
    """A function of the module's own text; overflow and the like give infinity and NaN, and no warning."""

    def quiet(*args: Any) -> Any:
        with np.errstate(all="ignore"):
            return function(*args)

    return quiet
