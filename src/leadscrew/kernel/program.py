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

ENGINES = ("numba", "python")
"""The engines that run a loop."""


class Program:
    """The compiled form of a loop; shared by all loops that differ in values only."""

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.module: Module = Linker(plan).link()

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
        if engine == "numba":
            found: Callable[..., Any] = getattr(self._numba, name)
            return found
        if engine == "python":
            return self._overflow_as_ieee(self._python[name])
        raise ValueRefused(f"engine = {engine!r}: there are {' and '.join(ENGINES)}")

    @staticmethod
    def _overflow_as_ieee(function: Callable[..., Any]) -> Callable[..., Any]:
        def quiet(*args: Any) -> Any:
            with np.errstate(all="ignore"):
                return function(*args)

        return quiet


__all__ = ["ENGINES", "Program"]
