"""A loop's generated module and its entries on each engine."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from functools import cached_property
from typing import TYPE_CHECKING, Any

from leadscrew.kernel.engines import ENGINES, by_python, check_engine, native
from leadscrew.kernel.linker import Linker, Plan
from leadscrew.kernel.module import Module
from leadscrew.kernel.trees import treework

if TYPE_CHECKING:
    from leadscrew.kernel.engines import Entry

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
        """The entry for a single run as the compiled engines take it, to read."""
        return self.module.text("single")

    @cached_property
    @treework()
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

    def entry(self, name: str, engine: str) -> Callable[..., Any]:
        """An entry of the module on an engine.

        Raises:
            ValueRefused: no such engine.
            EngineError: the engine ``c`` without a C compiler.
        """
        check_engine(engine)
        if engine == "python":
            return by_python(self._python[name])
        return self.native(name, engine)

    def native(self, name: str, engine: str = "llvm") -> Entry:
        """An entry as machine code: from our own lowering, or from C and the machine's compiler; kept in the cache."""
        if (name, engine) not in self._compiled:
            ranks = RANKS["single" if name == "single" else "lanes"]
            self._compiled[name, engine] = native(self.module, name, engine, self.title(name), ranks)
            self.module.drop_fused()
        return self._compiled[name, engine]


class Programs:
    """The latest programs of this process: a loop that differs from one of them in values alone is not linked again.

    A program serves a loop with the same steps, metrics, options and layout of parameters and state, as long as every
    function, global, closure variable and table that was compiled into it is unchanged.
    """

    LIMIT = 32

    def __init__(self) -> None:
        self._kept: OrderedDict[Hashable, list[Program]] = OrderedDict()
        self._lock = threading.Lock()

    def like(self, key: Hashable) -> list[Program]:
        """The programs under a key that are still current, the newest first."""
        with self._lock:
            kept = [p for p in self._kept.get(key, ()) if p.module.is_current()]
            if kept:
                self._kept[key] = kept
                self._kept.move_to_end(key)
            else:
                self._kept.pop(key, None)
            return list(kept)

    def add(self, key: Hashable, program: Program) -> None:
        """Keeps a program; beyond the limit the one whose key was not asked for the longest goes."""
        with self._lock:
            self._kept.setdefault(key, []).insert(0, program)
            self._kept.move_to_end(key)
            while sum(map(len, self._kept.values())) > self.LIMIT:
                oldest = next(iter(self._kept))
                self._kept[oldest].pop()
                if not self._kept[oldest]:
                    del self._kept[oldest]

    def clear(self) -> None:
        """Forgets all of them: the next loops are linked anew."""
        with self._lock:
            self._kept.clear()


programs = Programs()

__all__ = ["ENGINES", "Program", "programs"]
