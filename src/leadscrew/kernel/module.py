"""The generated module: every function, class and array that a loop reaches, under names of its own.

One module holds one loop. The compiled engines compile an entry with all that it calls fused in, and the hash of the
module is its place in the cache; the Python engine executes the same trees, each compiled under the file name and line
numbers that it was written in, so that pdb, tracebacks and coverage show the user's file.
"""

from __future__ import annotations

import ast
import hashlib
import types
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, cast

import numpy as np

from leadscrew.kernel import bits, guards
from leadscrew.kernel.block import Block
from leadscrew.kernel.branchless import branchless
from leadscrew.kernel.drivers import hooks
from leadscrew.kernel.flow import Flow
from leadscrew.kernel.fuse import Fuser
from leadscrew.kernel.ieee import OPERATORS, Ieee, Table
from leadscrew.kernel.normalise import Normaliser
from leadscrew.kernel.normalised_trees import Recorder, same, source_of, trees
from leadscrew.kernel.parameters import SILENT, leaf_type, notes
from leadscrew.kernel.scalarise import Scalariser, fields_of, without_copies, without_dead
from leadscrew.kernel.source import MISSING, lookup, where
from leadscrew.kernel.subset import MATHS, PRINT, call, is_named_tuple_type, is_print
from leadscrew.kernel.trees import code_of, copied, each, expression, fingerprint, treework
from leadscrew.util.errors import SubsetError
from leadscrew.util.frames import place

_RESERVED = {
    "ieee_select", PRINT, "np", "math", "NamedTuple", "float", "int", "bool", "abs", "len", "range", *bits.INTRINSICS,
    # the arguments and locals of the drivers and of what the linker writes
    *(  # noqa: SIM905
        "P A S B Q Z U V H R M D Y QA ZB p s x t k j n u f h g i c q v y b a lane run line views noise dt load "
        "driven memory here plant error command feedback output applied actual offset bound place places target "
        "source value values past row rows start end end_p end_a end_s every period periods countdown sound "
        "counters select span width first last base qa zb clock jac rates metrics sensor controller actuator "
        "reference disturbance output_disturbance substeps shown measured seed k1 k2 k3 k4 lu pivot ft left done "
        "fresh wanted signals state X sensed acted"
    ).split(),
}  # fmt: skip
"""Names that no definition of a module may have."""


_CODES: dict[tuple[str, bool, str, int], types.CodeType] = {}
MOST_CODES = 2048
"""Functions that the Python engine keeps compiled, for other modules with the same tree."""


@dataclass
class Item:
    """One definition of the module."""

    name: str
    node: ast.stmt
    filename: str
    kind: str
    """``class``, ``array``, ``leaf`` or ``entry``."""
    value: Any = None
    trusted: bool = False
    source: Sequence[Any] = ()
    """Of a function of the user: its code and defaults when it was added."""
    marked: bool = False
    """Whether something is noted on its nodes that the Python engine goes by."""

    @cached_property
    def print(self) -> str:
        """The fingerprint of its tree."""
        return fingerprint(self.node)

    def code(self) -> types.CodeType:
        """What the Python engine executes."""
        key = (self.print, self.trusted, self.filename, getattr(self.node, "lineno", 0))
        made = None if self.marked else _CODES.get(key)
        if made is None:
            node = Ieee(self.trusted).visit(copied(self.node))
            made = code_of(ast.Module([node], type_ignores=[]), self.filename)
            if not self.marked:
                if len(_CODES) >= MOST_CODES:
                    _CODES.clear()
                _CODES[key] = made
        return made


class Module:
    """Collects what a loop reaches; prints it for an engine."""

    def __init__(self) -> None:
        self.items: dict[str, Item] = {}
        self.names: dict[int, str] = {}
        self.kept: list[Any] = []
        self.constants: dict[str, float | int | bool] = {}
        """Values of the named hooks of the drivers that are plain numbers."""
        self.arguments: dict[tuple[int, str], type] = {}
        self._reads: dict[tuple[int, str], tuple[Any, str, Any, bytes]] = {}
        self._space: dict[str, Any] = {}
        self._working: set[int] = set()
        self._followed: set[str] = set()
        self._flow = Flow(self)
        self._effects: dict[str, bool] = {}
        self._fused: dict[str, ast.FunctionDef] = {}
        self._fuser: Fuser | None = None

    # ---- naming
    def fresh(self, wanted: str) -> str:
        """A name of the module that nothing has yet."""
        name, n = wanted, 1
        while name in self.items or name in _RESERVED:
            n += 1
            name = f"{wanted}_{n}"
        return name

    def _register(self, value: Any, item: Item) -> str:
        self.names[id(value)] = item.name
        self.kept.append(value)
        self.items[item.name] = item
        return item.name

    def link(self, hook: Callable[..., Any], name: str) -> None:
        """Makes the driver's ``hook`` stand for the definition ``name``."""
        self.names[id(hook)] = name
        self.kept.append(hook)

    def is_current(self) -> bool:
        """Whether every function and every global, closure variable and table that was compiled in is unchanged."""
        for holder, name, value, content in self._reads.values():
            now: Any = (
                lookup(holder, name) if isinstance(holder, types.FunctionType) else getattr(holder, name, MISSING)
            )
            if not same(now, value) or (content and now.tobytes() != content):
                return False
        return all(source_of(i.value) == i.source for i in self.items.values() if i.source)

    def argument_type(self, function: Callable[..., Any], argument: str) -> type | None:
        """The NamedTuple class of a step's ``p`` or ``s``, where the loop knows it."""
        return self.arguments.get((id(function), argument))

    def constant(self, name: str) -> float | int | bool | None:
        """The number that a named hook of the drivers stands for."""
        return self.constants.get(name)

    def outside(self, holder: Any, name: str, free: bool) -> Any:
        """What a free name of a function, or an attribute of an object, stands for now; the module takes note."""
        found = lookup(holder, name) if free else getattr(holder, name, MISSING)
        content = found.tobytes() if isinstance(found, np.ndarray) else b""
        self._reads[id(holder), name] = (holder, name, found, content)
        return found

    def _normalised(self, item: Item) -> None:
        """Puts the tree of a function into its item."""
        tree = trees.found(self, item.value, item.trusted, item.name)
        if tree is None:
            recorder = Recorder(self)
            worker = Normaliser(cast(Module, recorder), item.value, item.trusted)
            item.node, item.filename = worker.run(item.name), worker.filename
            item.print = trees.add(item.node, item.filename, item.trusted, item.value, recorder).print
        else:
            item.node, item.filename, item.print = copied(tree.node), tree.filename, tree.print

    # ---- adding
    def callable(self, found: Any, trusted: bool = False) -> str:
        """The name of a function, block's step or NamedTuple class, added if it is new."""
        if isinstance(found, Block):
            found = found.step
        if is_named_tuple_type(found):
            return self.named_tuple(found)
        if isinstance(found, types.BuiltinFunctionType):
            if found.__name__ not in MATHS:
                raise SubsetError(f"{found.__name__}() cannot be used in a step")
            found = MATHS[found.__name__]
        trusted = trusted or getattr(found, "__module__", "") in (
            guards.__name__,
            "leadscrew.kernel.noise",
        )
        trusted = trusted or (found.__module__ or "").startswith("leadscrew.kernel.portable")
        name = self.function(found, trusted)
        if not (trusted or self._working or name in self._followed or hasattr(found, "unguarded")):
            self._flow.root(name)
            self._followed.add(name)  # not before: a refused step is refused each time
        return name

    def function(self, function: Any, trusted: bool | None = None, kind: str = "leaf") -> str:
        """The name of a plain function in the module; it and all that it calls are added if new."""
        if id(function) in self._working:
            raise SubsetError(f"{where(function)}it calls itself; a step cannot recurse")
        if id(function) in self.names:
            return self.names[id(function)]
        home = function.__module__ or ""
        if function.__name__ in bits.INTRINSICS and home == bits.__name__:
            return str(function.__name__)
        if home == hooks.__name__:
            raise SubsetError(f"the driver's hook {function.__name__!r} is not linked")
        if trusted is None:
            trusted = home.startswith("leadscrew.kernel.")
        name = self.fresh(function.__name__)
        item = Item(name, ast.Pass(), "", kind, function, trusted, () if trusted else source_of(function))
        self._register(function, item)
        self._working.add(id(function))
        try:
            self._normalised(item)
        except BaseException:
            del self.items[name], self.names[id(function)]
            raise
        finally:
            self._working.discard(id(function))
        self.items[name] = self.items.pop(name)
        return name

    def has_effects(self, name: str) -> bool:
        """Whether a function of the module writes an array or holds a 'while', itself or in what it calls."""
        if name not in self._effects:
            node = self.items[name].node if name in self.items else ast.Pass()
            inside = list(each(node)) if isinstance(node, ast.FunctionDef) else []
            writes = any(isinstance(n, ast.Assign) and isinstance(n.targets[0], ast.Subscript) for n in inside)
            calls = (n.func.id for n in inside if isinstance(n, ast.Call) and isinstance(n.func, ast.Name))
            waits = any(isinstance(n, ast.While) or is_print(n) for n in inside)
            self._effects[name] = writes or waits or any(self.has_effects(c) for c in calls)
        return self._effects[name]

    def entry(self, driver: Any, name: str) -> str:
        """Adds a driver as an entry under a name, specialised by the constants that hold now."""
        self.names.pop(id(driver), None)
        self._fuser = None
        name = self.fresh(name)
        self.items[name] = Item(name, ast.Pass(), "", "entry", driver, True)
        self._normalised(self.items[name])
        self.items[name] = self.items.pop(name)
        return name

    def generated(self, name: str, args: list[str], body: list[ast.stmt]) -> str:
        """Adds a function written by the linker; returns its name."""
        name = self.fresh(name)
        given = [ast.arg(a) for a in args]
        taken = ast.arguments(posonlyargs=[], args=given, kwonlyargs=[], kw_defaults=[], defaults=[])
        node = ast.FunctionDef(  # type: ignore[call-arg]
            name=name, args=taken, body=body, decorator_list=[], type_params=[], lineno=1, col_offset=0
        )
        self.items[name] = Item(name, node, f"<leadscrew {name}>", "leaf", None, True)
        return name

    def power(self, n: int) -> str:
        """The name of ``x -> x**n`` as products, squares first."""
        name = f"power_{n}"
        if name in self.items:
            return name
        x: ast.expr = ast.Name("x", ast.Load())
        if n == 0:
            body: list[ast.stmt] = [ast.Return(ast.BinOp(ast.BinOp(x, ast.Sub(), x), ast.Add(), ast.Constant(1)))]
            body = [ast.Return(ast.Constant(1.0))]
        elif n == 1:
            body = [ast.Return(x)]
        else:
            half: ast.expr = call(self.power(n // 2), x)
            body = [ast.Assign([ast.Name("h", ast.Store())], half)]
            product: ast.expr = ast.BinOp(ast.Name("h", ast.Load()), ast.Mult(), ast.Name("h", ast.Load()))
            if n % 2:
                product = ast.BinOp(product, ast.Mult(), x)
            body.append(ast.Return(product))
        return self.generated(name, ["x"], body)

    def array(self, value: np.ndarray, hint: str) -> str:
        """The name of a constant array: its content is part of the module."""
        if id(value) in self.names:
            return self.names[id(value)]
        frozen = np.array(value, dtype=np.int64 if value.dtype.kind in "iub" else np.float64)
        name = self.fresh(hint.upper())
        rows = expression(f"np.array({frozen.tolist()!r}, dtype=np.{frozen.dtype.name})")
        for n in ast.walk(rows):
            if isinstance(n, ast.Name) and n.id in ("nan", "inf"):
                n.id = f"np.{n.id}"
        node = ast.fix_missing_locations(ast.Assign([ast.Name(name, ast.Store())], rows, lineno=1, col_offset=0))
        return self._register(value, Item(name, node, "", "array", frozen))

    def named_tuple(self, cls: Any) -> str:
        """The name of a NamedTuple class; nested ones are added first."""
        if id(cls) in self.names:
            return self.names[id(cls)]
        sheet = notes(cls)
        fields: list[ast.stmt] = []
        for field in cls._fields:
            note = sheet.get(field, SILENT)
            kind = self.named_tuple(note.base) if is_named_tuple_type(note.base) else leaf_type(note, None)
            kind = "np.ndarray" if kind == "array" else kind
            target = ast.Name(field, ast.Store())
            fields.append(ast.AnnAssign(target, expression(kind), None, simple=1))
        name = self.fresh(cls.__name__)
        base: list[ast.expr] = [ast.Name("NamedTuple", ast.Load())]
        node = ast.ClassDef(name, base, [], fields or [ast.Pass()], [], type_params=[])  # type: ignore[call-arg]
        return self._register(cls, Item(name, ast.fix_missing_locations(node), "", "class", cls))

    # ---- printing
    def ordered(self) -> list[Item]:
        """Classes, arrays, functions: each in the order in which it was completed."""
        rank = {"class": 0, "array": 1, "leaf": 2, "entry": 3}
        return sorted(self.items.values(), key=lambda i: rank[i.kind])

    def fused(self, name: str) -> ast.FunctionDef:
        """An entry with all that it calls fused in, NamedTuples taken apart, nothing left that nobody reads."""
        done = self._fused.get(name)
        if done is not None:
            return done
        for item in self.items.values():
            self.refuse_print(item)
        fuser = self._fuser  # another thread may drop it
        if fuser is None:
            leaves = {
                i.name: i.node for i in self.items.values() if isinstance(i.node, ast.FunctionDef) and i.kind == "leaf"
            }
            fuser = self._fuser = Fuser(leaves)
        classes = fields_of([i.node for i in self.ordered() if isinstance(i.node, ast.ClassDef)])
        harmless = {"float", "int", "bool", "abs", "float_to_bits", "bits_to_float", *classes}
        node = self.items[name].node
        assert isinstance(node, ast.FunctionDef)
        whole = Scalariser(classes).function(fuser.function(node))
        lean = without_dead(without_copies(without_dead(whole, harmless)), harmless)
        self._fused[name] = fused = branchless(lean)
        return fused

    def refuse_print(self, item: Item) -> None:
        """Refuses a step that prints, which only the Python engine can run.

        Raises:
            SubsetError: names file and line.
        """
        prints = () if item.trusted or item.kind != "leaf" else (n.lineno for n in each(item.node) if is_print(n))
        for line in prints:
            raise SubsetError(
                f"{place(item.filename, line)}: in {item.value.__name__!r}: print() in a step runs with "
                "engine='python' only"
            )

    def drop_fused(self) -> None:
        """Frees the fused trees, five times as large as all else; they are made again where they are needed."""
        self._fused.clear()
        self._fuser = None

    def arguments_of(self, name: str) -> list[str]:
        """The names of what an entry takes."""
        node = self.items[name].node
        assert isinstance(node, ast.FunctionDef)
        return [a.arg for a in node.args.args]

    def identity(self) -> str:
        """The hash of everything in the module: what an entry compiles to depends on nothing else."""
        parts = (f"{i.kind} {i.name} {i.print}" for i in sorted(self.items.values(), key=lambda i: i.name))
        return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:24]

    def arrays(self) -> dict[str, np.ndarray]:
        """The module's constant arrays."""
        return {i.name: i.value for i in self.ordered() if i.kind == "array"}

    def text(self, name: str) -> str:
        """An entry as the compiled engines take it and the arrays that it needs, to read."""
        parts = [ast.unparse(i.node) for i in self.ordered() if i.kind == "array"]
        parts.append(ast.unparse(ast.fix_missing_locations(self.fused(name))))
        return "\n\n".join(parts) + "\n"

    @treework()
    def namespace(self) -> dict[str, Any]:
        """The module for the Python engine: the same trees, under the user's own files and lines."""
        import math

        space = self._space
        if not space:
            space.update(__name__="leadscrew.generated", np=np, math=math, **OPERATORS, **{PRINT: print})
            space.update((name, getattr(bits, name)) for name in bits.INTRINSICS)
        for item in self.ordered():
            if item.name in space:
                continue
            if item.kind in ("class", "array"):
                whole = item.kind == "array" and item.value.dtype.kind == "i"
                space[item.name] = Table(item.value) if whole else item.value
                continue
            exec(item.code(), space)
        return space
