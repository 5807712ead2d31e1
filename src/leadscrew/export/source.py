"""The controller's own C: ``NAME.h`` and ``NAME.c``, printed from the same trees that were simulated."""

from __future__ import annotations

import ast
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from leadscrew.kernel.block import Block
from leadscrew.kernel.c99 import comments
from leadscrew.kernel.c99.comments import wrapped
from leadscrew.kernel.c99.expressions import Expressions
from leadscrew.kernel.c99.names import safe, safe_field
from leadscrew.kernel.c99.prelude import GUARD
from leadscrew.kernel.c99.translation import EMPTY, Translation
from leadscrew.kernel.c99.types import DOUBLE, FLOAT, INT, Number, Pair, Struct, Type, has_arrays
from leadscrew.kernel.frame import as_floats
from leadscrew.kernel.layout import Branch, Layout, Leaf, leaves
from leadscrew.kernel.module import Module
from leadscrew.kernel.trees import each
from leadscrew.util.errors import BlockError, SubsetError

INPUTS = ("command", "feedback")
LOCALS = ("params", "state", "p", "s", "r", "value", "next", "output", "command_", "feedback_", "exported", "fresh")
"""The names that the public functions use themselves."""


@dataclass(frozen=True)
class Argument:
    """One number that ``NAME_step`` takes or gives."""

    key: str
    name: str


def argument_name(key: str) -> str:
    """The C name of a signal's number: ``command``, ``command_velocity``; a position goes by its signal's name."""
    return safe("_".join(part for part in key.split(".") if part != "position"))


class Source:
    """Prints a controller. ``prepared`` and ``state`` are its values, ``signals`` an example of each signal."""

    def __init__(
        self, block: Block, prepared: Any, state: Any, signals: dict[str, Any], *, name: str, period: float, real: str,
        head: str,
    ) -> None:  # fmt: skip
        self.block, self.prepared, self.state, self.signals = block, prepared, state, signals
        self.name, self.period, self.head = name, period, head
        self.real: Number = FLOAT if real == "float" else DOUBLE
        self.module = Module()
        for value, arg in ((prepared, "p"), (state, "s")):
            if value is not None:
                self.module.arguments[id(block.step), arg] = type(value)
        if block.align is not None and prepared is not None:
            self.module.arguments[id(block.align), block.align.__code__.co_varnames[0]] = type(prepared)
        self.step = self.module.callable(block.step)
        self.unit = Translation(self.module, self.real, prefix=f"{name}_")
        ends = ("params", "state", "defaults", "start", "align", "step", "machine", "period")
        for end in ends:
            self.unit.fresh(f"{name}_{end}")
        self.literal = Expressions()
        self.literal.unit = self.unit
        self.stored: dict[Type, str] = {}
        self.inputs = [a for s in INPUTS for a in self.arguments(s) if self.wanted(a)]
        self.outputs = [Argument(a.key, a.name) for a in self.arguments("output")]
        self.unit.taken |= {*LOCALS, *self.names()}

    def names(self) -> set[str]:
        """The names of what ``NAME_step`` takes and gives.

        Raises:
            BlockError: two numbers would have one name.
        """
        found: dict[str, str] = {}
        for a in (*self.inputs, *self.outputs):
            if a.name in found:
                raise BlockError(
                    f"{self.block.name}: the signals {found[a.name]!r} and {a.key!r} would both be {a.name!r} in C; "
                    "rename one of the fields"
                )
            found[a.name] = a.key
        return set(found)

    # ---- signals
    def tree(self, signal: str) -> Leaf | Branch:
        """The layout of a signal."""
        return Layout(as_floats(self.signals[signal])).tree

    def arguments(self, signal: str) -> list[Argument]:
        """The numbers of a signal."""
        keys = [f"{signal}.{x.key}" if x.key else signal for x in leaves(self.tree(signal))]
        return [Argument(k, argument_name(k)) for k in keys]

    def wanted(self, argument: Argument) -> bool:
        """Whether an input is needed: the position always, anything else where the step reads it."""
        signal, *rest = argument.key.split(".")
        if not rest or rest == ["position"]:
            return True
        return any(self.reads(f, signal, rest[0]) for f in (self.block.step, self.block.align) if f is not None)

    def reads(self, function: Callable[..., Any], signal: str, field: str) -> bool:
        """Whether a function of the block reads a field of a signal, or hands the whole signal on."""
        names = function.__code__.co_varnames[: function.__code__.co_argcount]
        if signal not in names:
            return False
        node = self.module.items[self.module.callable(function)].node
        assert isinstance(node, ast.FunctionDef)
        mine = node.args.args[names.index(signal)].arg
        read = [n.attr for n in each(node) if isinstance(n, ast.Attribute) and ast.unparse(n.value) == mine]
        uses = sum(isinstance(n, ast.Name) and n.id == mine for n in each(node))
        return field in read or uses > len(read)

    # ---- values in C
    def number(self, value: Any, kind: Number) -> str:
        """A number as C source."""
        return self.literal.number(value, kind).text

    def initial(self, node: Leaf | Branch, value: Any, depth: int) -> str:
        """A value as the initialiser of its storage."""
        pad = "    " * depth
        if isinstance(node, Branch) and not node.parts:
            return "{0}"
        if isinstance(node, Branch):
            rows = [f"{pad}.{self.field(p)} = {self.initial(p, v, depth + 1)},"
                    for p, v in zip(node.parts, value, strict=True)]  # fmt: skip
            return "{\n" + "\n".join(rows) + f"\n{'    ' * (depth - 1)}}}"
        if node.kind != "array":
            return self.number(value, self.unit.number(node.kind))
        if not node.size:
            return "{0}"
        table = np.asarray(value, dtype=np.float64).reshape(node.shape[0], -1).tolist()
        rows = [", ".join(self.number(x, self.real) for x in row) for row in table]
        if len(node.shape) == 1:
            flat = ", ".join(rows)
            return f"{{{flat}}}"
        return "{\n" + ",\n".join(f"{pad}{row}" for row in rows) + f",\n{'    ' * (depth - 1)}}}"

    @staticmethod
    def field(node: Leaf | Branch) -> str:
        """The C name of a field."""
        return safe_field(node.key.rsplit(".", 1)[-1])

    def storage(self, node: Leaf | Branch, types: list[str]) -> str:
        """The declaration of a field that keeps its arrays in itself; nested types that need one go to ``types``."""
        name = self.field(node)
        if isinstance(node, Leaf):
            if node.kind == "array" and not node.shape:
                raise SubsetError(f"{self.block.name}: {node.key!r} is an array of no dimension; make it a float")
            if node.kind == "array":
                return f"{self.real.c} {name}[{max(1, node.size)}]"
            return self.unit.declaration(self.unit.number(node.kind), name)
        kind = self.unit.type_of(node, const=True)
        if not has_arrays(kind):
            self.unit.name_of(kind)
            self.publish(kind)
            return f"{self.unit.name_of(kind)} {name}"
        if kind not in self.stored:
            self.stored[kind] = self.unit.fresh(f"{self.name}_{node.type.__name__}")
            types.append(self.struct(self.stored[kind], node, types))
        return f"{self.stored[kind]} {name}"

    def publish(self, kind: Type) -> None:
        """Moves the definition of a type, and of those inside it, to the header."""
        if isinstance(kind, Struct):
            for _, inner in kind.fields:
                self.publish(inner)
            self.unit.name_of(kind)
            self.unit.outside.add(kind)

    def struct(self, title: str, node: Branch, types: list[str], first: str = "", last: str = "") -> str:
        """The definition of a storage type."""
        notes = comments.fields(node.type)
        rows = [first] if first else []
        for part in node.parts:
            key = part.key.rsplit(".", 1)[-1]
            shape = f"{' x '.join(map(str, part.shape))}" if isinstance(part, Leaf) and len(part.shape) > 1 else ""
            note = ", ".join(x for x in (notes.get(key, ""), shape) if x)
            rows.append(f"    {self.storage(part, types)};{f' /* {note} */' if note else ''}")
        rows += [last] if last else []
        rows = rows or [EMPTY]
        about = comments.block(comments.about(node.type))
        return f"{about}typedef struct {title} {{\n" + "\n".join(rows) + f"\n}} {title};\n"

    def view(self, node: Leaf | Branch, place: str, const: bool) -> str:
        """The value that a step sees, from its storage."""
        if isinstance(node, Leaf) or not has_arrays(self.unit.type_of(node, const)):
            return place
        return self.fields(node, place, const)

    def fields(self, node: Branch, place: str, const: bool) -> str:
        """A view, field by field."""
        dot = "" if place.endswith("->") else "."
        rows = ((self.field(p), self.view(p, f"{place}{dot}{self.field(p)}", const)) for p in node.parts)
        return f"{{{', '.join(f'.{name} = {text}' for name, text in rows) or '0'}}}"

    def stores(self, node: Leaf | Branch, place: str, source: str) -> list[str]:
        """Writes of a step's next state into its storage; arrays were written where they lie."""
        if isinstance(node, Leaf):
            return [] if node.kind == "array" else [f"{place} = {source};"]
        if not has_arrays(self.unit.type_of(node, const=False)):
            return [f"{place} = {source};"]
        return [
            line for p in node.parts for line in self.stores(p, f"{place}.{self.field(p)}", f"{source}.{self.field(p)}")
        ]

    def kept(self, state: Branch, source: str) -> list[str]:
        """Writes of a whole next state."""
        pairs = ((part, self.field(part)) for part in state.parts)
        return [line for part, f in pairs for line in self.stores(part, f"state->{f}", f"{source}.{f}")]

    def signal(self, signal: str) -> list[str]:
        """A local with a signal's value, where it is a NamedTuple."""
        tree = self.tree(signal)
        if isinstance(tree, Leaf):
            return []
        given = {a.key: a.name for a in self.inputs}

        def value(node: Leaf | Branch) -> str:
            if isinstance(node, Leaf):
                return given.get(f"{signal}.{node.key}", self.number(0.0, self.real))
            return f"{{{', '.join(f'.{self.field(p)} = {value(p)}' for p in node.parts) or '0'}}}"

        kind = self.unit.type_of(tree, const=True)
        return [f"const {self.unit.name_of(kind)} {signal}_ = {value(tree)};"]

    def filled(self, signal: str, given: dict[str, Any], number: Callable[[float], Any]) -> Any:
        """A signal's value from its numbers by key; 0 where an input is not taken."""
        return self.build(self.tree(signal), signal, given, number)

    def build(self, node: Leaf | Branch, signal: str, given: dict[str, Any], number: Callable[[float], Any]) -> Any:
        """A part of a signal's value."""
        if isinstance(node, Leaf):
            found = given.get(f"{signal}.{node.key}" if node.key else signal, number(0.0))
            return {"int": int, "bool": bool}.get(node.kind, number)(found)
        return node.type(*(self.build(p, signal, given, number) for p in node.parts))

    @staticmethod
    def numbers(value: Any) -> list[Any]:
        """The numbers of a signal, in order."""
        return [x for v in value for x in Source.numbers(v)] if isinstance(value, tuple) else [value]

    def signal_name(self, signal: str) -> str:
        """The local that holds a signal."""
        return signal if isinstance(self.tree(signal), Leaf) else f"{signal}_"

    def signal_type(self, signal: str) -> Type:
        """The type of a signal."""
        return self.unit.type_of(self.tree(signal), const=True)

    # ---- functions
    def signature(self, end: str, inputs: bool, *more: str, result: str = "void", const_state: bool = False) -> str:
        """The declaration of one of the public functions."""
        args = [f"const {self.name}_params *params", f"{self.name}_state *state"]
        args += [f"{self.real.c} {a.name}" for a in self.inputs] if inputs else []
        return f"{result} {self.name}_{end}({', '.join([*args, *more])})"

    def step_signature(self) -> str:
        """The declaration of ``NAME_step``."""
        if len(self.outputs) == 1:
            return self.signature("step", True, result=self.real.c)
        return self.signature("step", True, *(f"{self.real.c} *{o.name}" for o in self.outputs))

    def own(self, which: str, value: Any, const: bool) -> tuple[Branch | None, Type | None]:
        """Layout and type of the parameters or the state, where the block has any."""
        if value is None:
            return None, None
        tree = Layout(value).tree
        assert isinstance(tree, Branch)
        return tree, self.unit.type_of(tree, const)

    def used(
        self, function: Callable[..., Any], lead: list[tuple[str, Type]], signals: tuple[str, ...]
    ) -> tuple[str, Type, list[str]]:
        """A call of a function of the module: its text, its type, and the locals that it needs first."""
        kinds = [k for _, k in lead]
        texts = [t for t, _ in lead]
        before: list[str] = []
        for s in signals:
            if s in INPUTS:
                before += self.signal(s)
                kinds.append(self.signal_type(s))
                texts.append(self.signal_name(s))
            elif s == "t":
                kinds.append(self.real)
                texts.append("(double)state->periods * params->period")
            elif s == "dt":
                kinds.append(self.real)
                texts.append("params->period" if self.real is DOUBLE else "(float)params->period")
            else:
                kinds.append(self.real)
                texts.append(s)
        made = self.unit.function(self.module.callable(function), kinds)
        self.unit.roots.add(made.name)
        unused = [f"(void){a.name};" for a in self.inputs if a.key.split(".")[0] not in signals]
        return f"{made.name}({', '.join(texts)})", made.result, [*before, *unused]

    def step_body(self) -> list[str]:
        """The statements of ``NAME_step``."""
        params, p_kind = self.own("params", self.prepared, True)
        state, s_kind = self.own("state", self.state, False)
        lines, lead = self.views(params, p_kind, state, s_kind, self.block.signals)
        call, kind, before = self.used(self.block.step, lead, self.block.signals)
        lines += before
        if state is not None:
            assert isinstance(kind, Pair)
            lines.append(f"const {self.unit.name_of(kind)} r = {call};")
            lines.append("")
            lines += self.kept(state, "r.next")
            out = "r.value"
        else:
            lines.append(f"const {self.unit.name_of(kind)} value = {call};")
            lines.append("")
            out = "value"
        lines.append("state->periods++;")
        if len(self.outputs) == 1:
            tail = self.outputs[0].key.removeprefix("output")
            return [*lines, f"return {out}{tail};"]
        return [*lines, *(f"*{o.name} = {out}{o.key.removeprefix('output')};" for o in self.outputs)]

    def views(
        self, params: Branch | None, p_kind: Type | None, state: Branch | None, s_kind: Type | None,
        signals: tuple[str, ...],
    ) -> tuple[list[str], list[tuple[str, Type]]]:  # fmt: skip
        """The locals ``p`` and ``s``, and the arguments that they make."""
        lines: list[str] = []
        lead: list[tuple[str, Type]] = []
        for tree, kind, local, place in ((params, p_kind, "p", "params->"), (state, s_kind, "s", "state->")):
            if tree is not None and kind is not None:
                lines.append(f"const {self.unit.name_of(kind)} {local} = {self.fields(tree, place, local == 'p')};")
                lead.append((local, kind))
        if not (params and params.parts) and not {"t", "dt"} & set(signals):
            lines.append("(void)params;")
        return lines, lead

    def align_body(self) -> list[str]:
        """The statements of ``NAME_align``."""
        assert self.block.align is not None
        params, p_kind = self.own("params", self.prepared, True)
        state, _ = self.own("state", self.state, False)
        assert state is not None
        names = self.block.align.__code__.co_varnames[: self.block.align.__code__.co_argcount]
        lines, lead = self.views(params, p_kind, None, None, names)
        call, kind, before = self.used(self.block.align, lead, tuple(names[len(lead) :]))
        unused = [] if "output" in names else ["(void)output;"]
        lines += [*before, *unused, f"const {self.unit.name_of(kind)} next = {call};", ""]
        return [*lines, *self.kept(state, "next"), "state->periods = 0;"]

    def files(self, options: str = "") -> dict[str, str]:
        """``NAME.h`` and ``NAME.c``; ``options``: constants of C for the parameters."""
        n = self.name
        types: list[str] = []
        params, _ = self.own("params", self.prepared, True)
        state, _ = self.own("state", self.state, False)
        nothing = Branch("", type("Nothing", (tuple,), {"_fields": ()}), ())
        period = "    double period; /* control period, s */"
        count = "    int64_t periods; /* control periods since the start */"
        params_text = self.struct(f"{n}_params", params or nothing, types, first=period)
        state_text = self.struct(f"{n}_state", state or nothing, types, last=count)
        step, align = self.step_body(), self.align_body() if self.block.align is not None else []
        defaults = [f".period = {self.number(self.period, DOUBLE)},"]
        defaults += [f".{self.field(p)} = {self.initial(p, v, 2)}," for p, v in
                     zip(params.parts if params else (), self.prepared or (), strict=True)]  # fmt: skip
        start = [f".{self.field(p)} = {self.initial(p, v, 2)}," for p, v in
                 zip(state.parts if state else (), self.state or (), strict=True)]  # fmt: skip
        public = {
            f"void {n}_defaults({n}_params *params)": (
                "The parameters as exported.",
                constant(f"{n}_params", "exported", defaults, "params"),
            ),
            self.signature("start", False): (
                "The state at the start.",
                [*constant(f"{n}_state", "fresh", [*start, ".periods = 0,"], "state"), "(void)params;"],
            ),
        }
        if align:
            public[self.signature("align", True, f"{self.real.c} output")] = (
                "The state from which the controller goes on without a jump after this output.", align)  # fmt: skip
        public[self.step_signature()] = ("One control period: from command and feedback to the output.", step)
        published = [text for kind, (_, text) in self.unit.types.items() if kind in self.unit.outside]
        guard = f"{n.upper()}_H"
        header = [
            self.head, f"#ifndef {guard}\n#define {guard}\n", self.unit.includes(), CPP_OPEN, *published, *types,
            *filter(None, [options]), params_text, state_text,
            *(f"/* {note} */\n{sign};\n" for sign, (note, _) in public.items()), CPP_CLOSE,
            "#endif\n",
        ]  # fmt: skip
        bodies = [
            f"{sign}\n{{\n" + "\n".join(y for x in indented(lines) for y in wrapped(f"    {x}")) + "\n}\n"
            for sign, (_, lines) in public.items()
        ]
        includes = self.unit.includes("float.h")
        code = [self.head, f'#include "{n}.h"\n', includes, GUARD, self.unit.text(), *bodies]
        return {f"{n}.h": "\n".join(header), f"{n}.c": "\n".join(code)}


CPP_OPEN = '#ifdef __cplusplus\nextern "C" {\n#endif\n'
CPP_CLOSE = "#ifdef __cplusplus\n}\n#endif\n"


def constant(kind: str, name: str, rows: list[str], target: str) -> list[str]:
    """Statements that set a struct to a constant."""
    return [f"static const {kind} {name} = {{", *(f"    {x}" for x in rows), "};", "", f"*{target} = {name};"]


def indented(lines: list[str]) -> list[str]:
    """Lines of C, those of a multi-line initialiser kept as they are."""
    return [part for line in lines for part in line.split("\n")]


__all__ = ["INT", "Argument", "Source", "argument_name"]
