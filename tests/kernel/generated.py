"""Random steps of the subset as Python text: numbers of three kinds, arrays, loops, branches, calls with effects."""

import linecache
import random
from typing import Any

from leadscrew.kernel.module import Module
from leadscrew.util.errors import SubsetError

HEAD = """\
import math
from typing import NamedTuple

import numpy as np

from leadscrew.kernel.bits import stack_array2

TABLE = np.array([1.5, -2.0, 0.0, 1e300])
COUNTS = np.array([3, -1, 2])
GRID = np.array([[1.0, 2.0], [-3.0, 0.5]])


class V(NamedTuple):
    x: float = 0.0
    k: int = 0
    on: bool = False


class P(NamedTuple):
    gain: float = 0.5
    many: int = 3
    inner: V = V(2.0, 5, True)


class S(NamedTuple):
    x: float = 0.25
    k: int = 1
    on: bool = False
    v: V = V()
    a: np.ndarray = np.zeros(3)


def poke(a, i, x):
    a[i] = x + a[(i + 1) % 3]
    return a[0] - x


def early(x, k):
    for i in range(k % 5):
        if x > i:
            return x - i
        if x < -i:
            return -1
    return 2.5 * k


def both(x, k):
    if x > 0.5:
        return V(x, k, True), x
    return V(x * 2.0, k + 1, x == 0.0), 3


def shifted(s, x):
    if x > 0.5:
        s.a[0] = x
        return s
    return S(x, s.k % 7, not s.on, s.v, s.a)


def turned(v, x):
    return V(v.x - x, v.k % 7, not v.on)


def seen(x):
    return x if abs(x) < 1e100 else math.copysign(3.0, x) if x == x else 7.0


def shown(x, y, z, w):
    # a number that the signs of all four decide, also those of zeros and NaN
    signs = math.copysign(1.0, x) + math.copysign(2.0, y) + math.copysign(4.0, z) + math.copysign(8.0, w)
    total = seen(x) + seen(y) + seen(z) + seen(w)
    return signs if total == 0.0 else total * (16.5 + signs)
"""
FLOATS = ("0.0", "-0.0", "np.nan", "1.0", "-0.5", "0.1", "3.0", "1e308", "5e-324", "1e16", "2.0**53", "-1e-3")
BEYOND = ("np.inf", "1e39")
INTS = (0, 1, 2, 3, 7, 10, 255, 1000, 65537)


class Step:
    """One random step."""

    def __init__(self, seed: int, effects: bool = True) -> None:
        self.random, self.seed = random.Random(seed), seed
        self.effects = effects
        self.floats = ["x", "y", "z", "command", "feedback", "p.gain", "s.x", "p.inner.x", "v.x"]
        self.ints = ["k", "m", "p.many", "v.k", "s.k"]
        self.bools = ["b", "c", "s.on", "p.inner.on", "v.on"]
        self.lines: list[str] = []
        self.calls = False

    def pick(self, *options: Any) -> Any:
        return self.random.choice(options)

    def real(self, depth: int) -> str:
        """A float."""
        r = self.random
        if depth <= 0:
            return self.pick(r.choice(self.floats), r.choice(self.floats), r.choice(FLOATS + BEYOND), self.element())
        a = self.real(depth - 1)
        kind = r.randrange(18)
        if kind < 5:
            other = self.real(depth - 1) if r.random() < 0.7 else self.whole(depth - 1)
            return f"({a} {self.pick('+', '-', '*', '/', '//', '%')} {other})"
        if kind == 5:
            return f"({a} if {self.truth(depth - 1)} else {self.real(depth - 1)})"
        if kind == 6:
            return f"{self.pick('min', 'max')}({a}, {self.pick(self.real(depth - 1), self.whole(0))})"
        if kind == 7:
            return (
                f"{self.pick('abs', 'math.floor', 'math.ceil', 'math.trunc', 'np.sign', 'math.sqrt', 'math.sin')}({a})"
            )
        if kind == 8:
            return f"(-{a})"
        if kind == 9:
            return f"({self.whole(depth - 1)} / {self.whole(depth - 1)})"
        if kind == 10:
            return f"({a}){self.pick('**2', '**3', '**-1', '**0.5')}"
        if kind == 11 and self.calls:
            return f"poke({self.pick('s.a', 'w')}, {r.randrange(-1, 4)}, {a})"
        if kind == 12:
            return f"early({a}, {self.whole(0)})"
        if kind in (13, 14):
            return f"math.copysign({a}, {self.real(depth - 1)})"
        if kind == 15:
            return f"math.atan2({self.pick('int', 'round', 'float')}({a}), {self.real(depth - 1)})"
        if kind == 16:
            return f"(1.0 * {self.whole(depth - 1)})"
        return f"(1.0 * {self.truth(depth - 1)} + {a})"

    def element(self) -> str:
        """An element of an array."""
        at = self.pick("0", "1", "-1", "k % 4", "m % 3 - 1", "2")
        by = self.pick("k % 4", "m % 3 - 1", "int(COUNTS[k % 4])")
        return self.pick(f"s.a[{at}]", f"w[{at}]", f"t[{at}]", f"TABLE[{at}]", f"COUNTS[{by}]", f"s.a[{by}]",
                         f"GRID[1, {self.pick('0', '-1', 'k % 3')}]")  # fmt: skip

    def whole(self, depth: int) -> str:
        """An integer of 64 bits, which wraps."""
        r = self.random
        if depth <= 0 or r.random() < 0.2:
            if r.random() < 0.4:
                return str(r.choice(INTS))
            return self.pick(*self.ints, "COUNTS[0]", "int(COUNTS[m % 4])", "len(TABLE)", "s.a.shape[0]")
        a, b = self.whole(depth - 1), self.whole(depth - 1)
        kind = r.randrange(13)
        if kind < 3:
            return f"({a} {'*+-'[kind]} {b})"
        if kind in (3, 4):
            return f"({a} {self.pick('//', '%')} {b})"
        if kind == 5:
            return f"({a} {self.pick('&', '|', '^')} {b})"
        if kind == 6:
            return f"({a} {self.pick('<< 3', '>> 2', '<< 9', '>> 40')})"
        if kind == 7:
            return f"({self.pick('-', '~', '+')}{a})"
        if kind == 8:
            return f"({a} if {self.truth(depth - 1)} else {b})"
        if kind == 9:
            return f"({self.truth(depth - 1)} {self.pick('+', '-', '*', '^', '&')} {self.truth(depth - 1)})"
        if kind in (10, 11):
            return f"{self.pick('int', 'round')}({self.real(depth - 1)})"
        return f"{self.pick('abs', 'int')}({a})"

    def truth(self, depth: int) -> str:
        """A truth value."""
        r = self.random
        if depth <= 0:
            return self.pick(*self.bools, "(x > y)", "(k == 2)", "True", "(m < k)")
        sign = self.pick("<", "<=", ">", ">=", "==", "!=")
        kind = r.randrange(7)
        if kind == 0:
            return f"({self.real(depth - 1)} {sign} {self.real(depth - 1)})"
        if kind == 1:
            return f"({self.whole(depth - 1)} {sign} {self.whole(depth - 1)})"
        if kind == 2:
            return f"(not {self.truth(depth - 1)})"
        if kind == 3:
            other = self.pick("<", "!=", ">=")
            return f"({self.real(0)} {sign} {self.whole(0)} {other} {self.real(depth - 1)})"
        if kind == 4:
            return f"({self.truth(depth - 1)} {sign} {self.truth(depth - 1)})"
        joined = self.pick("and", "or")
        return f"({self.truth(depth - 1)} {joined} {self.truth(depth - 1)})"

    def put(self, depth: int, line: str) -> None:
        self.lines.append("    " * depth + line)

    def statement(self, depth: int, loops: int) -> None:
        """One statement."""
        r = self.random
        self.calls = self.effects and r.random() < 0.3
        kind = r.randrange(17)
        if kind == 15:
            self.put(depth, f"t = {self.pick('s.a', 's.a', 'w')}")
        elif kind == 16:
            self.put(depth, f"s = shifted(s, {self.plain_real(1)})")
        elif kind in (0, 1, 2):
            self.put(depth, f"{self.pick('x', 'y', 'z')} {self.pick('=', '=', '+=', '*=', '-=')} {self.plain_real(3)}")
        elif kind == 3:
            self.put(
                depth, f"{self.pick('k', 'm')} = {self.plain(lambda: self.whole(3))} % {self.pick(7, 1000, 65537)}"
            )
        elif kind == 4:
            self.put(depth, f"{self.pick('b', 'c')} = {self.plain(lambda: self.truth(3))}")
        elif kind == 5:
            self.put(depth, f"{self.pick('s.a', 'w')}[{self.pick('0', '-1', 'k % 4', 'm % 3')}] = {self.plain_real(2)}")
        elif kind == 6:
            self.put(depth, self.pick("x, y = y, x", "x, z = z - y, x + 1.0", "k, m = m, k", "b, x = x > y, z"))
        elif kind == 7:
            self.put(depth, f"v, {self.pick('x', 'z')} = both({self.plain_real(1)}, k)")
        elif kind == 8:
            self.put(depth, f"v = {self.plain(lambda: self.chosen())}")
        elif kind in (9, 10) and depth < 4:
            self.put(depth, f"if {self.plain(lambda: self.truth(2))}:")
            self.block(depth + 1, loops)
            if r.random() < 0.6:
                self.put(depth, "else:")
                self.block(depth + 1, loops)
        elif kind in (11, 12) and depth < 4 and loops < 2:
            bounds = self.pick("3", "k % 4", "3, -1, -2", "0, 5, p.many - 1", "m % 3, 3", "2, 2", "-1, k % 3")
            self.put(depth, f"for {self.pick('i', 'i', 'j', 'k')} in range({bounds}):")
            self.block(depth + 1, loops + 1)
            if r.random() < 0.4:
                self.put(depth + 1, f"if {self.plain(lambda: self.truth(1))}:")
                self.put(depth + 2, self.pick("break", "continue"))
                self.block(depth + 1, loops + 1)
        elif kind == 13 and depth < 3 and loops < 1:
            self.put(depth, "n = 0")
            self.put(depth, f"while n < 4 {self.pick('and', 'and not')} {self.plain(lambda: self.truth(1))}:")
            self.put(depth + 1, "n += 1")
            self.block(depth + 1, loops + 1)
        elif self.effects:
            self.put(depth, f"poke({self.pick('s.a', 'w')}, k % 4, {self.plain_real(1)})")
        else:
            self.put(depth, f"x + {self.real(1)}")

    def chosen(self) -> str:
        kind = self.random.randrange(3)
        if kind == 0:
            return f"V({self.real(2)}, {self.whole(1)} % 1000, {self.truth(2)})"
        if kind == 1:
            return f"turned(v if {self.truth(1)} else p.inner, {self.real(1)})"
        return f"v._replace(x={self.real(1)}, on={self.truth(1)})"

    def plain(self, made: Any) -> str:
        """An expression without calls that write."""
        self.calls = False
        return str(made())

    def plain_real(self, depth: int) -> str:
        """A float; where it has calls that write, none under a condition."""
        if not self.calls:
            return self.real(depth)
        self.calls = False
        parts = [self.real(depth - 1), f"poke({self.pick('s.a', 'w')}, {self.random.randrange(-1, 4)}, {self.real(1)})",
                 self.element(), f"poke(w, k % 3, poke(s.a, 1, {self.real(0)}))"]  # fmt: skip
        self.random.shuffle(parts)
        return f" {self.pick('+', '-', '*')} ".join(parts[: self.random.randrange(2, 5)])

    def block(self, depth: int, loops: int) -> None:
        for _ in range(self.random.randrange(1, 3)):
            self.statement(depth, loops)

    def text(self, name: str) -> str:
        """The step as Python text."""
        self.lines = []
        self.random.seed(self.seed)
        for _ in range(self.random.randrange(4, 9)):
            self.statement(1, 0)
        top = ["x = command", "y = s.x", "z = feedback", "k = s.k", "m = p.many", "b = s.on", "c = command > 0.0",
               "v = s.v", "w = np.zeros(3)", "t = s.a", "i = 0", "j = 1", "n = 2",
               "for i in range(3):", "    if not abs(s.a[i]) < 1e300:", "        s.a[i] = 0.5 * i"]  # fmt: skip
        state = f"S(x - y if abs(x - y) < 1e300 else 0.75, (k + i + m) % {self.pick(1000, 2**40)}, b, v, s.a)"
        end = f"return {state}, shown(x, y + (1 if c else 0) + k * 1e-3, z + s.a[1] + w[0] + j + n, v.x)"
        return f"def {name}(p, s, command, feedback):\n" + "\n".join(f"    {x}" for x in top) + "\n" + "\n".join(
            [*self.lines, f"    {end}"]
        )  # fmt: skip


def driver(names: list[str]) -> str:
    """A function that plays rows of inputs through every step."""
    lines = ["def drive(F, G):"]
    for column, name in enumerate(names):
        lines += [
            f"    room{column} = stack_array2(1, 3)",
            "    for i in range(3):",
            f"        room{column}[0, i] = 0.0",
            f"    s{column} = S(0.25, 1, False, V(0.0, 0, False), room{column}[0])",
        ]
        lines += [
            "    for row in range(F.shape[0]):",
            f"        s{column}, u{column} = {name}(P(0.5, 3, V(2.0, 5, True)), s{column}, F[row, 0], F[row, 1])",
            f"        G[row, {column}] = 1.0 * u{column}",
        ]
    return "\n".join([*lines, "    return 0"])


def module_of(steps: list[Any], params: type, state: type) -> Module:
    """A module of steps."""
    module = Module()
    for step in steps:
        module.arguments[id(step), "p"], module.arguments[id(step), "s"] = params, state
        module.callable(step)
    return module


def accepted(text: str) -> bool:
    """Whether a step is in the subset: the random ones now and then take a remainder of doubtful kind."""
    space: dict[str, Any] = {}
    name = f"<generated {hash(text)}>"
    whole = f"{HEAD}\n\n{text}\n"
    linecache.cache[name] = (len(whole), None, whole.splitlines(keepends=True), name)
    exec(compile(whole, name, "exec"), space)
    try:
        module_of([space["step"]], space["P"], space["S"])
    except SubsetError:
        return False
    return True


def module_text(seed: int, count: int) -> str:
    """A module of random steps and their driver."""
    names = [f"step_{i}" for i in range(count)]
    steps = []
    trial = 1000 * seed
    while len(steps) < count:
        trial += 1
        made = Step(trial, effects=len(steps) % 2 == 0)
        if accepted(made.text("step")):
            steps.append(made.text(names[len(steps)]))
    return "\n\n\n".join([HEAD, *steps, driver(names)]) + "\n"
