"""One C file's worth of a module: its types, tables and functions, each printed when it is first asked for."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from leadscrew.kernel import guards
from leadscrew.kernel.c99 import comments, prelude
from leadscrew.kernel.c99.comments import wrapped
from leadscrew.kernel.c99.expressions import Expressions, Value
from leadscrew.kernel.c99.functions import Function
from leadscrew.kernel.c99.names import safe, safe_field
from leadscrew.kernel.c99.prelude import GUARD
from leadscrew.kernel.c99.types import (
    BOOL,
    DOUBLE,
    FLOAT,
    INT,
    Array,
    Number,
    Pair,
    Struct,
    Type,
    as_local,
    has_arrays,
    sized,
    sizes_of,
)
from leadscrew.kernel.layout import Branch, Leaf
from leadscrew.kernel.module import Item, Module

PORTABLE, GENERIC = "leadscrew.kernel.portable", ("maximum", "minimum")
NOISE = "leadscrew.kernel.noise"
EMPTY = "    char nothing;"
"""The field of a struct that has none: C wants one."""


@dataclass(frozen=True)
class Made:
    """A function that was printed."""

    name: str
    arguments: list[Type]
    result: Type


class Translation:
    """Prints what is asked for, and what that needs, in an order that C accepts."""

    def __init__(self, module: Module, real: Number = DOUBLE, prefix: str = "") -> None:
        self.module, self.real, self.prefix = module, real, prefix
        self.types: dict[Type, tuple[str, str]] = {}
        self.outside: set[Type] = set()
        """Types that are defined in the header."""
        self.tables: dict[str, tuple[str, str]] = {}
        self.functions: dict[tuple[str, tuple[Type, ...]], tuple[Made, str, set[str]]] = {}
        self.roots: set[str] = set()
        """The functions and tables that what stands outside uses."""
        self.headers: set[str] = set()
        self.helpers: dict[str, str] = {}
        self.reserved: set[str] = {*prelude.HELPERS, *module.items}
        self.taken: set[str] = set(prelude.HELPERS)

    # ---- what the printed text needs
    def include(self, header: str) -> None:
        """Notes that a standard header is used."""
        self.headers.add(header)

    def help(self, name: str) -> None:
        """Notes that a helper is used."""
        if name not in self.helpers:
            for header in prelude.HELPERS[name][0]:
                self.include(header)
            self.helpers[name] = prelude.helper(name, self.real.c)

    def has_effects(self, name: str) -> bool:
        """Whether a function of the module writes an array, itself or in what it calls."""
        return name in self.module.items and self.module.has_effects(name)

    def is_class(self, name: str) -> bool:
        """Whether a name is a NamedTuple of the module."""
        return name in self.module.items and self.module.items[name].kind == "class"

    # ---- types
    def number(self, kind: str) -> Number:
        """The type of a field from its annotation."""
        return {"int": INT, "bool": BOOL}.get(kind, self.real)

    def type_of(self, node: Leaf | Branch, const: bool) -> Type:
        """The type of a value with a layout."""
        if isinstance(node, Leaf):
            return Array(self.real, node.shape, const) if node.kind == "array" else self.number(node.kind)
        return self.struct_of(self.module.named_tuple(node.type), [self.type_of(p, const) for p in node.parts])

    def struct_of(self, name: str, given: list[Type]) -> Struct:
        """The type of a NamedTuple that is built from values of these types."""
        node = self.module.items[name].node
        assert isinstance(node, ast.ClassDef)
        fields = []
        declared = [s for s in node.body if isinstance(s, ast.AnnAssign)]
        for s, kind in zip(declared, given, strict=True):
            text = ast.unparse(s.annotation)
            field = ast.unparse(s.target)
            fields.append((field, self.number(text) if text in ("float", "int", "bool") else kind))
        return Struct(name, tuple(fields))

    def field(self, kind: Struct, name: str) -> str:
        """The C name of a field."""
        return safe_field(name)

    def items(self, kind: Type) -> list[tuple[str, Type]]:
        """The fields of a NamedTuple or a returned tuple: ``next`` and ``value`` where that is a state and a signal."""
        if isinstance(kind, Struct):
            return [(self.field(kind, f), t) for f, t in kind.fields]
        assert isinstance(kind, Pair)
        if len(kind.items) == 2 and isinstance(kind.items[0], Struct):
            return list(zip(("next", "value"), kind.items, strict=True))
        return [(f"v{i}", k) for i, k in enumerate(kind.items)]

    def name_of(self, kind: Type) -> str:
        """The C name of a type; its definition is printed if it is new."""
        if isinstance(kind, Number):
            if kind is BOOL:
                self.include("stdbool.h")
            return kind.c
        if kind in self.types:
            return self.types[kind][0]
        if isinstance(kind, Array):
            return f"{'const ' if kind.const else ''}{kind.element.c} *"
        if isinstance(kind, Struct):
            pairs: list[tuple[str, Type]] = [(self.field(kind, f), t) for f, t in kind.fields]
            view = "_view" if has_arrays(kind) else ""
            name = self.fresh(f"{self.prefix}{kind.name}{view}")
            notes = comments.fields(self.module.items[kind.name].value)
            about = comments.about(self.module.items[kind.name].value)
            keys = [f for f, _ in kind.fields]
        else:
            pairs, about, notes = self.items(kind), [], {}
            keys = [f for f, _ in pairs]
            first = kind.items[0]
            stem = self.name_of(first) if isinstance(first, Struct) else f"{self.prefix}tuple{len(kind.items)}"
            name = self.fresh(f"{stem}_and_value" if isinstance(first, Struct) and len(pairs) == 2 else stem)
        lines = [] if pairs else [EMPTY]
        for (field, t), key in zip(pairs, keys, strict=True):
            note = f" /* {notes[key]} */" if notes.get(key) else ""
            lines.append(f"    {self.declaration(t, field)};{note}")
        head = comments.block(about)
        self.types[kind] = (name, f"{head}typedef struct {name} {{\n" + "\n".join(lines) + f"\n}} {name};\n")
        return name

    def fresh(self, wanted: str) -> str:
        """A name of the file that nothing has yet."""
        name = safe(wanted, self.taken)
        n = 1
        while name in self.taken:
            n += 1
            name = safe(f"{wanted}_{n}", self.taken)
        self.taken.add(name)
        self.reserved.add(name)
        return name

    def declaration(self, kind: Type, name: str) -> str:
        """The declaration of a local or field."""
        text = self.name_of(kind)
        return f"{text}{name}" if text.endswith("*") else f"{text} {name}"

    def zero(self, kind: Type) -> str:
        """A value to begin with."""
        if isinstance(kind, Number):
            return {BOOL: "false", INT: "0", FLOAT: "0.0f", DOUBLE: "0.0"}[kind]
        if isinstance(kind, Array):
            self.include("stddef.h")
            return "NULL"
        parts = [k for _, k in kind.fields] if isinstance(kind, Struct) else kind.items
        return f"{{{', '.join(self.zero(k) for k in parts) or '0'}}}"

    # ---- tables
    def table(self, name: str) -> Value | None:
        """A constant array of the module, where it has one of that name."""
        item = self.module.items.get(name)
        if item is None or item.kind != "array":
            return None
        value: np.ndarray = item.value
        whole = value.dtype.kind == "i"
        element = INT if whole else self.real
        kind = Array(element, value.shape, const=True)
        if name not in self.tables:
            c_name = self.fresh(f"{name}_table")
            printer = Expressions()
            printer.unit = self
            rows = value.reshape(value.shape[0], -1).tolist() if value.size else [[0]]
            lines = ",\n".join("    " + ", ".join(printer.number(x, element).text for x in row) for row in rows)
            text = f"static const {element.c} {c_name}[{max(1, value.size)}] = {{\n{lines}\n}};\n"
            self.tables[name] = (c_name, text)
        return Value(self.tables[name][0], kind)

    # ---- functions
    def real_of(self, item: Item) -> Number:
        """What a float is inside a function: the portable mathematics computes with doubles whatever is asked for."""
        home = getattr(item.value, "__module__", None) or ""
        name = getattr(item.value, "__name__", "")
        island = home.startswith((PORTABLE, NOISE)) and name not in GENERIC
        return DOUBLE if island else self.real

    def function(self, name: str, given: list[Type], caller: Expressions | None = None, at: Any = None) -> Made:
        """A function of the module for arguments of these types; printed if it is new."""
        item = self.module.items.get(name)
        if item is None or not isinstance(item.node, ast.FunctionDef):
            assert caller is not None
            caller.refuse(at, f"a call of {name!r}")
        self.module.refuse_print(item)
        real = self.real_of(item)
        kinds = [self.passed(k, real, item) for k in given]
        wanted = tuple(kinds)
        if (name, wanted) in self.functions:
            return self.functions[name, wanted][0]
        printer = self.printer(item, kinds, real)
        if any(isinstance(k, Array) and not k.const for k in kinds) and self.only_reads(name, printer):
            kinds = [Array(k.element, k.shape, const=True) if isinstance(k, Array) else k for k in kinds]
            if (name, tuple(kinds)) in self.functions:
                self.functions[name, wanted] = (self.functions[name, tuple(kinds)][0], "", set())
                return self.functions[name, wanted][0]
            printer = self.printer(item, kinds, real)
        assert printer.result is not None
        arguments = printer.arguments
        title = self.fresh(self.title(item, kinds))
        made = Made(title, [printer.types[a] for a in arguments], printer.result)
        body = printer.body()
        taken = [[self.declaration(k, printer.names[a]), *(f"int64_t {n}" for n in sizes_of(k))]
                 for a, k in arguments.items()]  # fmt: skip
        args = ", ".join(x for group in taken for x in group)
        result = self.name_of(printer.result)
        gap = "" if result.endswith("*") else " "
        head = comments.block(comments.about(item.value), comments.place(item))
        text = f"{head}static {result}{gap}{title}({args or 'void'})\n{{\n{body}\n}}\n"
        self.functions[name, tuple(kinds)] = (made, text, printer.uses)
        if tuple(kinds) != wanted:
            self.functions[name, wanted] = (made, "", set())
        return made

    def printer(self, item: Item, kinds: list[Type], real: Number) -> Function:
        """What prints a function for arguments of these types, all types told."""
        assert isinstance(item.node, ast.FunctionDef)
        pairs = zip((a.arg for a in item.node.args.args), kinds, strict=True)
        arguments = {a: sized(k, a) for a, k in pairs}
        self.reserved |= {size for k in arguments.values() for size in sizes_of(k)}
        notes = {} if item.trusted else comments.lines(item.value)
        made = Function(self, item.node, arguments, real, comments.place(item), notes)
        made.infer()
        return made

    def only_reads(self, name: str, printer: Function) -> bool:
        """Whether a function neither writes arrays nor hands them on."""
        return not self.has_effects(name) and printer.result is not None and not has_arrays(printer.result)

    def passed(self, kind: Type, real: Number, item: Item) -> Type:
        """The type that a function takes for an argument of a type."""
        if isinstance(kind, Number) and kind is FLOAT and real is DOUBLE:
            return DOUBLE
        if isinstance(kind, Array):
            shape = tuple(n if isinstance(n, int) else f"{i}" for i, n in enumerate(kind.shape))
            return Array(kind.element, shape, kind.const)
        if kind is BOOL and item.trusted:
            return INT
        return as_local(kind, local=False)

    @staticmethod
    def title(item: Item, kinds: list[Type]) -> str:
        """A function's wanted name in C: that of the module, marked where it is ours."""
        home = getattr(item.value, "__module__", None) or ""
        if item.value is None or home.startswith((PORTABLE, guards.__name__, NOISE)):
            whole = "i" if all(k in (INT, BOOL) for k in kinds) and item.name in GENERIC else ""
            whole = whole or ("f" if FLOAT in kinds else "")
            known = [k for k in kinds if isinstance(k, Array) and not sizes_of(k)]
            sizes = [f"_{'x'.join(map(str, k.shape))}" for k in known]
            return f"ls_{item.name.strip('_')}{whole}{''.join(sizes)}"
        return item.name

    # ---- the file
    def text(self) -> str:
        """What was printed and is used from ``roots``: types, helpers, tables, functions."""
        wanted = set(self.roots)
        functions: list[str] = []
        for made, text, inside in reversed(self.functions.values()):
            if text and made.name in wanted:
                wanted |= inside
                functions.insert(0, text)
        parts = [text for kind, (_, text) in self.types.items() if kind not in self.outside]
        tables = [text for name, text in self.tables.values() if name in wanted]
        return "\n".join([*parts, *self.helpers.values(), *tables, *functions])

    def includes(self, *more: str) -> str:
        """The standard headers."""
        return "".join(f"#include <{h}>\n" for h in sorted({*self.headers, "stdint.h", *more}))


Ranks = Mapping[str, tuple[int, str]]


def entry_function(unit: Translation, node: ast.FunctionDef, ranks: Ranks, title: str) -> str:
    """One entry as a C function: every array as a pointer followed by its sizes, as the machine code takes them."""
    arguments: dict[str, Type] = {}
    taken: list[str] = []
    for a in node.args.args:
        rank, element = ranks[a.arg]
        sizes = tuple(f"{a.arg}_size{i}" for i in range(rank))
        kind = Array(DOUBLE if element == "f" else INT, sizes)
        arguments[a.arg] = kind
        taken += [f"{kind.element.c} *restrict {a.arg}", *(f"int64_t {s}" for s in sizes)]
        unit.reserved |= {*sizes}
    printer = Function(unit, node, arguments, DOUBLE, node.name, {})
    printer.infer()
    body = printer.body()
    unit.roots |= printer.uses
    head = "\n".join(wrapped(f"{title}({', '.join(taken)})"))
    return f"{head}\n{{\n{body}\n}}\n"


def entry_text(module: Module, name: str, ranks: Ranks, *, fused: bool = True) -> str:
    """The C source of an entry.

    ``fused=False`` prints every function that it calls as one of its own, NamedTuples and all: slower to compile.
    """
    unit = Translation(module)
    node = module.fused(name) if fused else module.items[name].node
    assert isinstance(node, ast.FunctionDef)
    text = entry_function(unit, node, ranks, f"int64_t {name}")
    head = "/* Generated by leadscrew: do not edit. */\n"
    return f"{head}{unit.includes('float.h')}\n{GUARD}\n{unit.text()}\n{text}"
