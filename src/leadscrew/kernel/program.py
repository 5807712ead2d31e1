"""A loop's generated module and its entries on each engine."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np

from leadscrew.kernel import cache
from leadscrew.kernel.errors import ValueRefused
from leadscrew.kernel.linker import Linker, Plan
from leadscrew.kernel.module import Module

ENGINES = ("llvm", "numba", "python")
RANKS: dict[str, dict[str, tuple[int, str]]] = {
    "single": {"P": (1, "f"), "A": (1, "f"), "S": (1, "f"), "B": (1, "f"), "counters": (1, "i"), "select": (1, "i"),
               "Y": (2, "f"), "M": (2, "f")},
    "lanes": {"P": (1, "f"), "A": (1, "f"), "S": (1, "f"), "B": (1, "f"), "QA": (1, "f"), "ZB": (1, "f"),
              "places": (1, "i"), "values": (2, "f"), "span": (1, "i"), "select": (1, "i"), "Y": (3, "f"), "M": (2, "f"),
              "D": (1, "i")},
}  # fmt: skip
"""Dimensions and element (``f`` float, ``i`` integer) of what the entries take."""
"""The engines that run a loop."""


class Program:
    """The compiled form of a loop; shared by all loops that differ in values only."""

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.module: Module = Linker(plan).link()
        self._compiled: dict[str, Callable[..., Any]] = {}

    @cached_property
    def text(self) -> str:
        """The module's text, which the Numba engine compiles."""
        return self.module.text()

    @cached_property
    def name(self) -> str:
        """The module's name: the hash of its text."""
        return cache.module_name(self.text)

    @cached_property
    def _python(self) -> dict[str, Any]:
        return self.module.namespace()

    @cached_property
    def _numba(self) -> Any:
        path = cache.store(self.text)
        spec = importlib.util.spec_from_file_location(self.name, path)
        assert spec is not None and spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        sys.modules[self.name] = module
        spec.loader.exec_module(module)
        return module

    def entry(self, name: str, engine: str) -> Callable[..., Any]:
        """An entry of the module on an engine.

        Raises:
            ValueRefused: no such engine.
        """
        if engine == "llvm":
            return self._native(name)
        if engine == "numba":
            found: Callable[..., Any] = getattr(self._numba, name)
            return found
        if engine == "python":
            return self._overflow_as_ieee(self._python[name])
        raise ValueRefused(f"engine = {engine!r}: there are {', '.join(ENGINES)}")

    def _native(self, name: str) -> Callable[..., Any]:
        from leadscrew.kernel.native import compiled

        if name not in self._compiled:
            module, ranks = self.module, RANKS["single" if name == "single" else "lanes"]
            self._compiled[name] = compiled(module.entries()[name], module.text((name,)), ranks, module.arrays())
        return self._compiled[name]

    @staticmethod
    def _overflow_as_ieee(function: Callable[..., Any]) -> Callable[..., Any]:
        def quiet(*args: Any) -> Any:
            with np.errstate(all="ignore"):
                return function(*args)

        return quiet


__all__ = ["ENGINES", "Program"]
