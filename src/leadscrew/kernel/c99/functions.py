"""One function of the module as a C function, for arguments of given types."""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from leadscrew.kernel.c99.comments import wrapped
from leadscrew.kernel.c99.expressions import UNARY, Expressions, Unknown, Value, WritesConstant
from leadscrew.kernel.c99.names import safe
from leadscrew.kernel.c99.types import INT, Array, Number, Pair, Type, arrays_of, joined, sizes_of
from leadscrew.kernel.trees import each

if TYPE_CHECKING:
    from leadscrew.kernel.c99.translation import Translation

Path = tuple[tuple[int, int], ...]
"""From the outside in: which block, and which statement in it."""


def _blocks(node: ast.stmt) -> list[list[ast.stmt]]:
    return [b for f in ("body", "orelse") if isinstance(b := getattr(node, f, None), list) and b]


class Places:
    """Knows for every local where it is set and read."""

    def __init__(self, node: ast.FunctionDef, arguments: set[str]) -> None:
        self.arguments = arguments
        self.seen: dict[str, list[Path]] = {}
        self.sets: dict[str, int] = {}
        self.statements: dict[Path, ast.stmt] = {}
        self.starts: dict[int, list[str]] = {}
        self.first: dict[str, int] = {}
        self.loops: dict[str, list[ast.For]] = {}
        self.counters: dict[str, bool] = {}
        self.walk(node.body, ())
        for name in self.seen:
            if name not in arguments:
                self.settle(name)

    def walk(self, body: list[ast.stmt], outer: Path) -> None:
        """Notes every use of a name, statement by statement."""
        for i, node in enumerate(body):
            path = (*outer, (id(body), i))
            self.statements[path] = node
            for n in self.own(node):
                self.seen.setdefault(n.id, []).append(path)
                if isinstance(n.ctx, ast.Store):
                    self.sets[n.id] = self.sets.get(n.id, 0) + 1
            if isinstance(node, ast.For) and isinstance(node.target, ast.Name):
                self.loops.setdefault(node.target.id, []).append(node)
            for block in _blocks(node):
                self.walk(block, path)

    @staticmethod
    def own(node: ast.stmt) -> Iterator[ast.Name]:
        """The names of a statement, without those in its blocks."""
        for field in node._fields:
            value = getattr(node, field, None)
            if field in ("body", "orelse") and isinstance(value, list):
                continue
            for part in value if isinstance(value, list) else [value]:
                if isinstance(part, ast.AST):
                    for n in each(part):
                        if isinstance(n, ast.Name):
                            yield n

    def settle(self, name: str) -> None:
        """Finds the innermost block with all uses of a local, and whether it begins by setting it."""
        paths = self.seen[name]
        depth = 0
        while all(len(p) > depth + 1 for p in paths) and len({p[depth] for p in paths}) == 1:
            # All uses are within one statement: go into the block of it that has them, if one block has them all.
            if len({p[depth + 1][0] for p in paths}) != 1:
                break
            depth += 1
        block = paths[0][depth][0]
        here = min((p for p in paths if p[depth][0] == block), key=lambda p: p[depth][1])
        node = self.statements[here[: depth + 1]]
        exact = [p for p in paths if p == here[: depth + 1]]
        named = [n for n in self.own(node) if n.id == name]
        if exact and isinstance(node, ast.Assign) and len(named) == 1:
            self.first[name] = id(node)
        elif not self.is_counter(name):
            self.starts.setdefault(block, []).append(name)

    def at_start(self, body: list[ast.stmt]) -> list[str]:
        """The locals to declare where a block begins."""
        return self.starts.get(id(body), [])

    def begins(self, name: str, node: ast.stmt) -> bool:
        """Whether a local begins with this statement."""
        return self.first.get(name) == id(node)

    def once(self, name: str) -> bool:
        """Whether a local is set in one place only."""
        return self.sets.get(name, 0) == 1

    def is_counter(self, name: str) -> bool:
        """Whether a local is only ever the counter of loops, set by them alone and used inside them alone."""
        if name not in self.counters:
            loops = self.loops.get(name, [])
            inside = [n for loop in loops for n in each(loop)]
            uses = sum(isinstance(n, ast.Name) and n.id == name for n in inside)
            ours = {id(loop) for loop in loops}
            nested = sum(id(n) in ours for n in inside) > len(loops)
            alone = bool(loops) and self.sets.get(name, 0) == len(loops) and uses == len(self.seen.get(name, []))
            self.counters[name] = alone and not nested
        return self.counters[name]


class Function(Expressions):
    """Types and prints one function; call :meth:`infer`, then :meth:`body`."""

    def __init__(
        self, unit: Translation, node: ast.FunctionDef, arguments: Mapping[str, Type], real: Number, place: str,
        comments: Mapping[int, list[str]],
    ) -> None:  # fmt: skip
        self.unit, self.node, self.real, self.place = unit, node, real, place
        self.comments = dict(comments)
        self.arguments = dict(arguments)
        self.types: dict[str, Type] = dict(arguments)
        self.result: Type | None = None
        self.unknown: ast.stmt | None = None
        self.out: list[str] = []
        self.depth = 1
        self.count = 0
        self.linear = False
        self.loops: list[tuple[str, ast.expr]] = []
        self.printing = False
        self.uses: set[str] = set()
        self.sizes: dict[str, int] = {}
        found = list(dict.fromkeys([*arguments, *(n.id for n in each(node) if isinstance(n, ast.Name)
                                                  and isinstance(n.ctx, ast.Store))]))  # fmt: skip
        self.names = dict.fromkeys(found, "")
        self.name_locals()

    def name_locals(self) -> None:
        """Gives every local a name that nothing of the file has."""
        self.taken: set[str] = set(self.unit.reserved)
        for name in self.names:
            self.names[name] = safe(name, self.taken)
            self.taken.add(self.names[name])

    # ---- types
    def infer(self) -> None:
        """The type of every local and of the result.

        Raises:
            SubsetError: a local that holds values of two kinds.
        """
        loops = any(isinstance(n, ast.For | ast.While) for n in each(self.node))
        while True:
            before = dict(self.types), self.result
            self.unknown = None
            self.pass_over(self.node.body)
            if before == (self.types, self.result) or not (loops or self.unknown):
                break
        if self.unknown is not None:
            self.refuse(self.unknown, "a value of unknown type")
        if self.result is None:
            self.refuse(self.node, "a function that returns nothing")
        self.arguments = {a: self.types[a] for a in self.arguments}
        self.name_locals()

    def pass_over(self, body: list[ast.stmt]) -> None:
        """Takes note of statements in the order in which they run."""
        for node in body:
            try:
                self.note(node)
            except Unknown:
                self.unknown = node
            for field in ("body", "orelse"):
                self.pass_over(getattr(node, field, []))

    def note(self, n: ast.stmt) -> None:
        """Takes note of what a statement says of types."""
        if isinstance(n, ast.For) and isinstance(n.target, ast.Name):
            self.widen(n.target.id, INT, n)
        elif isinstance(n, ast.Assign):
            target = n.targets[0]
            if isinstance(target, ast.Name) and self.room(n.value) is not None:
                shape = self.room(n.value)
                assert shape is not None
                self.widen(target.id, Array(self.real, shape, local=True), n)
            elif not isinstance(target, ast.Subscript):
                self.spread(target, self.value(n.value).type, n)
        elif isinstance(n, ast.Return) and n.value is not None:
            kind = self.value(n.value).type
            if any(array.local for array in arrays_of(kind)):
                self.refuse(n, "a function that returns an array of its own")
            both = kind if self.result is None else joined(self.result, kind)
            if both is None:
                self.refuse(n, "a function that returns values of two types")
            self.result = both

    def spread(self, target: ast.expr, kind: Type, node: ast.stmt) -> None:
        """Gives the names of a target their types."""
        if isinstance(target, ast.Name):
            self.widen(target.id, kind, node)
            return
        if not isinstance(kind, Pair) or not isinstance(target, ast.Tuple) or len(kind.items) != len(target.elts):
            self.refuse(node, "an assignment of other than as many values as names")
        for t, k in zip(target.elts, kind.items, strict=True):
            self.spread(t, k, node)

    def widen(self, name: str, kind: Type, node: ast.stmt) -> None:
        """Gives a local at least this type."""
        both = joined(self.types[name], kind) if name in self.types else kind
        if both is None:
            self.refuse(node, f"the local {name!r}, which holds values of two types,")
        self.types[name] = both

    def room(self, node: ast.expr) -> tuple[int, ...] | None:
        """The shape of a new local array, where an expression is one."""
        if not isinstance(node, ast.Call) or ast.unparse(node.func) not in ("np.zeros", "np.empty", "stack_array2"):
            return None
        sizes = node.args[0].elts if node.args and isinstance(node.args[0], ast.Tuple) else node.args
        return tuple(int(self.value(s).literal or 0) for s in sizes)

    # ---- printing
    def put(self, line: str) -> None:
        """A line at the present depth."""
        self.out += wrapped("    " * self.depth + line)

    def local(self, stem: str) -> str:
        """A name that no local has."""
        self.count += 1
        name = safe(f"{stem}{self.count}", self.taken)
        self.taken.add(name)
        return name

    def body(self) -> str:
        """The statements, between the braces."""
        self.printing = True
        self.uses = set()
        self.places = Places(self.node, set(self.arguments))
        self.buffers()
        used = [n for n in each(self.node) if isinstance(n, ast.Name)]
        self.read = {n.id for n in used if isinstance(n.ctx, ast.Load)}
        self.block(self.node.body)
        self.note_unread()
        text = "\n".join(self.out)
        words = {w for line in self.out if line.lstrip()[:2] != "/*" for w in re.findall(r"\w+", line)}
        self.uses &= words
        sizes = [n for kind in self.arguments.values() for n in sizes_of(kind) if n not in words]
        return "\n".join([*(f"    (void){n};" for n in sizes), text])

    def note_unread(self) -> None:
        """Says so of locals that are read in Python but not in C, where a size or a comparison is known."""
        text = "\n".join(line for line in self.out if line.lstrip()[:2] != "/*")
        read = set(re.findall(r"(?<![.\w>])[A-Za-z]\w*\b(?! = )", text))
        for name in (n for n in self.names.values() if n not in read):
            at = next((i for i, line in enumerate(self.out) if re.match(rf"[\w ]+[ *]{name} = ", line)), None)
            if at is not None:
                end = next(i for i in range(at, len(self.out)) if self.out[i].endswith(";"))
                indent = re.match(" *", self.out[at])
                assert indent is not None
                self.out.insert(end + 1, f"{indent.group()}(void){name};")
            elif name in (self.names[a] for a in self.arguments):
                self.out.insert(0, f"    (void){name};")

    def buffers(self) -> None:
        """Room for local arrays, one for each place that makes one."""
        self.room_of: dict[int, str] = {}
        for n in each(self.node):
            if isinstance(n, ast.Assign) and isinstance(n.targets[0], ast.Name):
                shape = self.room(n.value)
                if shape is not None:
                    name = self.local(f"{self.names[n.targets[0].id]}_room")
                    size = max(1, math.prod(shape))
                    clear = " = {0}" if "stack_array2" in ast.unparse(n.value) else ""
                    self.put(f"{self.real.c} {name}[{size}]{clear};")
                    self.room_of[id(n)] = name

    def declared(self, name: str, value: str = "") -> str:
        """A declaration, with a value or none."""
        return self.unit.declaration(self.types[name], self.names[name]) + (f" = {value};" if value else ";")

    def block(self, body: list[ast.stmt]) -> None:
        """Statements, after the declarations that must come first."""
        for name in self.places.at_start(body):
            kind = self.types.get(name)
            if kind is not None:
                self.put(self.declared(name, self.unit.zero(kind)))
                if name not in self.read:
                    self.put(f"(void){self.names[name]};")
        for node in body:
            for line in self.comments.pop(getattr(node, "lineno", 0), []):
                self.put(f"/* {line} */")
            self.linear = self.effects(node)
            getattr(self, f"do_{type(node).__name__.lower()}")(node)

    def effects(self, node: ast.stmt) -> bool:
        """Whether an expression of the statement calls what writes an array, other than as the whole of it."""
        tops = [v for f in ("value", "test", "iter") if isinstance(v := getattr(node, f, None), ast.expr)]
        calls = [n for top in tops for n in each(top) if isinstance(n, ast.Call) and n not in tops]
        return any(isinstance(n.func, ast.Name) and self.unit.has_effects(n.func.id) for n in calls)

    def hoisted(self, value: Value) -> Value:
        return self.held(value) if self.linear else value

    def held(self, value: Value) -> Value:
        if not self.printing:
            return value
        name = self.local("t")
        const = "" if isinstance(value.type, Array) else "const "
        self.put(f"{const}{self.unit.declaration(value.type, name)} = {value.text};")
        return Value(name, value.type)

    def do_pass(self, node: ast.stmt) -> None:
        """Nothing."""

    def do_expr(self, node: ast.Expr) -> None:
        if isinstance(node.value, ast.Constant | ast.Name):
            return
        self.top = node.value
        value = self.value(node.value)
        called = isinstance(node.value, ast.Call) and value.text.split("(")[0] in self.uses
        self.put(f"{value.text};" if called else f"(void){self.inside(value, UNARY)};")

    def do_break(self, node: ast.stmt) -> None:
        self.put("break;")

    def do_continue(self, node: ast.stmt) -> None:
        self.put("continue;")

    def do_return(self, node: ast.Return) -> None:
        assert node.value is not None and self.result is not None
        if isinstance(node.value, ast.Tuple) and isinstance(self.result, Pair):
            parts = [self.value(e) for e in node.value.elts]
            texts = [self.assigned(p, t) for p, t in zip(parts, self.result.items, strict=True)]
            self.put(f"return ({self.unit.name_of(self.result)}){{{', '.join(texts)}}};")
            return
        self.put(f"return {self.assigned(self.value(node.value), self.result)};")

    def do_assign(self, node: ast.Assign) -> None:
        target = node.targets[0]
        if isinstance(target, ast.Subscript):
            value = self.value(node.value)
            place = self.place_of(target)
            assert isinstance(place.type, Number)
            array = self.value(target.value).type
            if isinstance(array, Array) and array.const:
                raise WritesConstant(f"in {self.node.name!r}: a write into a constant array: {ast.unparse(node)[:100]}")
            self.put(f"{place.text} = {self.assigned(value, place.type)};")
        elif isinstance(target, ast.Name):
            room = self.room_of.get(id(node))
            if room is not None:
                self.store(target, room, node)
                if ast.unparse(node.value).startswith("np.zeros"):
                    self.unit.include("string.h")
                    self.put(f"memset({room}, 0, sizeof {room});")
                return
            value = self.value(node.value)
            if self.printing and self.places.once(target.id):
                self.sizes[target.id] = value.reach
            self.store(target, self.assigned(value, self.types[target.id]), node)
        elif isinstance(target, ast.Tuple):
            self.unpack(target, node)

    def place_of(self, target: ast.Subscript) -> Value:
        """An element that is written."""
        linear, self.linear = self.linear, False
        found = self.value(ast.Subscript(target.value, target.slice, ast.Load()))
        self.linear = linear
        return found

    def store(self, target: ast.Name, text: str, node: ast.stmt) -> None:
        """Sets a local, and declares it where this is where it begins."""
        if self.places.begins(target.id, node):
            idle = target.id not in self.read
            constant = "const " if self.places.once(target.id) and isinstance(self.types[target.id], Number) else ""
            self.put(constant + self.declared(target.id, text))
            if idle:
                self.put(f"(void){self.names[target.id]};")
        else:
            self.put(f"{self.names[target.id]} = {text};")

    def unpack(self, target: ast.Tuple, node: ast.Assign) -> None:
        """``a, b = ...``, all values before any name."""
        if isinstance(node.value, ast.Tuple):
            flat = self.matched(target, node.value)
            read = {n.id for _, v in flat for n in each(v) if isinstance(n, ast.Name)}
            held = [(t, self.value(v)) for t, v in flat]
            if {t.id for t, _ in flat} & read and len(flat) > 1:
                kept = [(t, self.held(v)) for t, v in held]
                held = kept
            for t, v in held:
                self.store(t, self.assigned(v, self.types[t.id]), node)
            return
        value = self.value(node.value)
        assert isinstance(value.type, Pair)
        self.taken_apart(target, self.held(value).text, value.type, node)

    def matched(self, target: ast.Tuple, value: ast.Tuple) -> list[tuple[ast.Name, ast.expr]]:
        """Names and values of a tuple assignment, tuples within tuples taken apart."""
        found: list[tuple[ast.Name, ast.expr]] = []
        for t, v in zip(target.elts, value.elts, strict=True):
            if isinstance(t, ast.Tuple) and isinstance(v, ast.Tuple):
                found += self.matched(t, v)
            elif isinstance(t, ast.Name):
                found.append((t, v))
            else:
                self.refuse(target, "this assignment")
        return found

    def taken_apart(self, target: ast.Tuple, text: str, kind: Pair, node: ast.stmt) -> None:
        """Names from the fields of a returned tuple."""
        for t, (field, k) in zip(target.elts, self.unit.items(kind), strict=True):
            if isinstance(t, ast.Tuple) and isinstance(k, Pair):
                self.taken_apart(t, f"{text}.{field}", k, node)
            elif isinstance(t, ast.Name):
                self.store(t, self.assigned(Value(f"{text}.{field}", k), self.types[t.id]), node)

    def do_if(self, node: ast.If) -> None:
        self.put(f"if ({self.truth(self.value(node.test)).text}) {{")
        self.indented(node.body)
        rest = node.orelse
        if rest and not all(isinstance(n, ast.Pass) for n in rest):
            self.put("} else {")
            self.indented(rest)
        self.put("}")

    def indented(self, body: list[ast.stmt]) -> None:
        """A block one step further in."""
        self.depth += 1
        self.block(body)
        self.depth -= 1

    def do_while(self, node: ast.While) -> None:
        if self.linear:
            self.put("for (;;) {")
            self.depth += 1
            test = self.truth(self.value(node.test))
            self.put(f"if (!({test.text})) {{")
            self.put("    break;")
            self.put("}")
            self.block(node.body)
            self.depth -= 1
        else:
            self.put(f"while ({self.truth(self.value(node.test)).text}) {{")
            self.indented(node.body)
        self.put("}")

    def next_of(self, counter: str, by: str, end: Value) -> str:
        """Moves a counter on; where that would leave 64 bits, to the end."""
        self.unit.help("range_next")
        return f"{counter} = range_next({counter}, {by}, {end.text})"

    def do_for(self, node: ast.For) -> None:
        assert isinstance(node.iter, ast.Call) and isinstance(node.target, ast.Name)
        given = [self.value(a) for a in node.iter.args]
        low, high = (self.number(0, INT), given[0]) if len(given) == 1 else (given[0], given[1])
        by = given[2] if len(given) > 2 else self.number(1, INT)
        name = self.names[node.target.id]
        plain = self.places.is_counter(node.target.id)
        counter = name if plain else self.local("k")
        if plain and self.printing:
            self.sizes[node.target.id] = max(low.reach, high.reach)
        if high.literal is None:
            end = self.local("end")
            self.put(f"const int64_t {end} = {high.text};")
            high = Value(end, INT)
        if by.literal is None:
            step = self.local("step")
            self.put(f"const int64_t {step} = {by.text};")
            test = f"{step} > 0 ? {counter} < {high.text} : {step} < 0 && {counter} > {high.text}"
            move = self.next_of(counter, step, high)
        else:
            if by.literal == 0:
                low = high = self.number(0, INT)
            sign = "<" if by.literal >= 0 else ">"
            test = f"{counter} {sign} {high.text}"
            near = high.literal is not None and abs(high.literal) + abs(by.literal) < 2**62
            further = f"{counter} += {by.text}" if near else self.next_of(counter, by.text, high)
            move = {1: f"{counter}++", -1: f"{counter}--"}.get(int(by.literal), further)
        self.put(f"for (int64_t {counter} = {low.text}; {test}; {move}) {{")
        if not plain:
            self.depth += 1
            self.put(f"{name} = {counter};")
            self.depth -= 1
        self.indented(node.body)
        self.put("}")
