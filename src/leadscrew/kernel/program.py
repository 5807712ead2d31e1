"""A loop's generated module and its entries on each engine."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.kernel import cache
from leadscrew.kernel.errors import ValueRefused
from leadscrew.kernel.linker import Linker, Plan
from leadscrew.kernel.module import Module

if TYPE_CHECKING:
    from leadscrew.kernel.native import Entry

ENGINES = ("llvm", "c", "numba", "python")
"""The engines that run a loop."""
RANKS: dict[str, dict[str, tuple[int, str]]] = {
    "single": {"P": (1, "f"), "A": (1, "f"), "S": (1, "f"), "B": (1, "f"), "counters": (1, "i"), "select": (1, "i"),
               "Y": (2, "f"), "M": (2, "f")},
    "lanes": {"P": (1, "f"), "A": (1, "f"), "S": (1, "f"), "B": (1, "f"), "QA": (1, "f"), "ZB": (1, "f"),
              "places": (1, "i"), "values": (2, "f"), "span": (1, "i"), "select": (1, "i"), "Y": (3, "f"),
              "M": (2, "f"), "D": (1, "i")},
    "split": {"P": (1, "f"), "A": (1, "f"), "S": (1, "f"), "B": (1, "f"), "X": (1, "f"), "counters": (1, "i")},
}  # fmt: skip
"""Dimensions and element (``f`` float, ``i`` integer) of what the entries take."""


class Program:
    """The compiled form of a loop; shared by all loops that differ in values only."""

    def __init__(self, plan: Plan, module: Module) -> None:
        self.plan = plan
        self.linker = Linker(plan, module)
        self.module = self.linker.link()
        self.name = f"loop_{self.module.identity()}"
        """The loop's name in the cache and in manifests: the hash of its module."""
        self._compiled: dict[tuple[str, str], Entry] = {}

    @cached_property
    def text(self) -> str:
        """The text of the entry for a single run, which the compiled engines compile."""
        return self.module.text("single")

    @cached_property
    def batches(self) -> str:
        """Adds the entries for batches to the module; gives its name with them."""
        self.linker.lanes()
        return f"loop_{self.module.identity()}"

    def title(self, name: str) -> str:
        """What an entry is called in the cache; the entry is there afterwards."""
        return f"{self.name if name == 'single' else self.batches}_{name}"

    @cached_property
    def _python(self) -> dict[str, Any]:
        return self.module.namespace()

    def _numba(self, name: str) -> Callable[..., Any]:
        text = self.module.text(name)
        title = cache.module_name(text)
        if title not in sys.modules:
            spec = importlib.util.spec_from_file_location(title, cache.store(text))
            assert spec is not None and spec.loader is not None
            module = importlib.util.module_from_spec(spec)
            sys.modules[title] = module
            spec.loader.exec_module(module)
        found: Callable[..., Any] = getattr(sys.modules[title], name)
        return found

    def entry(self, name: str, engine: str) -> Callable[..., Any]:
        """An entry of the module on an engine.

        Raises:
            ValueRefused: no such engine.
            EngineError: the engine ``c`` without a C compiler.
        """
        if engine in ("llvm", "c"):
            return self.native(name, engine)
        if engine == "numba":
            self.title(name)
            return self._numba(name)
        if engine == "python":
            return self._overflow_as_ieee(self._python[name])
        raise ValueRefused(f"engine = {engine!r}: there are {', '.join(ENGINES)}")

    def native(self, name: str, engine: str = "llvm") -> Entry:
        """An entry as machine code: from our own lowering, or from C and the machine's compiler; kept in the cache."""
        if (name, engine) not in self._compiled:
            compiled: Callable[..., Entry]
            if engine == "c":
                from leadscrew.kernel.compiler import compiled
            else:
                from leadscrew.kernel.native import compiled
            ranks = RANKS["single" if name == "single" else "lanes"]
            self._compiled[name, engine] = compiled(self.module, name, self.title(name), ranks)
        return self._compiled[name, engine]

    @staticmethod
    def _overflow_as_ieee(function: Callable[..., Any]) -> Callable[..., Any]:
        def quiet(*args: Any) -> Any:
            with np.errstate(all="ignore"):
                return function(*args)

        return quiet


__all__ = ["ENGINES", "Program"]
