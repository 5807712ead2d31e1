"""Links a loop's blocks into the hooks of the drivers and gives the generated module."""

from __future__ import annotations

import ast
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from leadscrew.kernel import portable
from leadscrew.kernel.block import Block
from leadscrew.kernel.drivers import continuous, fixed, hooks, lanes, rodas, single
from leadscrew.kernel.frame import SLOTS, Pair, bundle, pairs, under
from leadscrew.kernel.layout import Branch, Layout, Leaf, leaves
from leadscrew.kernel.module import Module
from leadscrew.kernel.syntax import add, assign, both, call, do, give, item, minus, name, put, times, within
from leadscrew.util.errors import BlockError

METHODS: dict[str, Callable[..., Any]] = {"rk4": fixed.rk4, "sdirk3": fixed.sdirk3, "rodas": rodas.rodas}
"""Integrators by name; a plant that takes ``dt`` brings its own step."""
LARGEST = 1.7976931348623157e308
LIMITS: dict[str, float | int] = {"float": LARGEST, "int": 2**53 - 1}
"""Of the numbers of a state, by kind; a whole one is kept from period to period as a double."""
LANES = 16
TAIL = ("reference", "disturbance", "output_disturbance", "sensor", "controller", "actuator")
"""Slots whose state the sampling stage writes."""


@dataclass
class Plan:
    """All that decides the text of a module: blocks, types, options, no values."""

    blocks: dict[str, Block | None]
    metrics: dict[str, Block]
    params: Layout
    state: Layout
    signals: dict[str, Any]
    """Example of each signal: ``command, feedback, output, applied, actual, load``; floats or NamedTuples."""
    method: str
    sent: tuple[int, int] = (0, 0)
    """Computational delay: whole periods and further substeps."""
    seen: int = 0
    """Transport delay in substeps."""
    continuous: bool = False
    rtol: float = 1e-6
    atol: float = 1e-9
    columns: list[str] = field(default_factory=list)
    """What can be recorded, in order; filled by the linker."""

    def layout(self) -> tuple[Any, ...]:
        """Where every value lies, and the types that hold them."""
        signals = {k: Layout(v).tree for k, v in self.signals.items()}
        return self.params.tree, self.state.tree, signals


def body_of(node: Leaf | Branch, module: Module, leaf: Callable[[Leaf], ast.expr]) -> ast.expr:
    """Syntax that builds a value, with an expression for every leaf."""
    if isinstance(node, Leaf):
        return leaf(node)
    return call(module.named_tuple(node.type), *(body_of(p, module, leaf) for p in node.parts))


def scalar_leaves(node: Leaf | Branch) -> list[Leaf]:
    """The leaves that are numbers."""
    return [x for x in leaves(node) if x.kind != "array"]


def is_absent(leaf: Leaf) -> bool:
    """Whether a leaf of the state only holds the place of a block without state."""
    return leaf.kind != "array" and leaf.key in (*SLOTS, "metrics", "sent", "seen")


class Linker:
    """Writes small functions for a loop, links them to the hooks of the drivers, and puts the drivers together."""

    def __init__(self, plan: Plan, module: Module) -> None:
        self.plan = plan
        self.module = module
        self.module.constants.update(RTOL=plan.rtol, ATOL=plan.atol, TIMED=False, LANES=LANES)
        self.state_parts = {p.key: p for p in self._parts(plan.state.tree)}
        self.trees = {k: Layout(v).tree for k, v in plan.signals.items()}
        self.actual_pairs = pairs(self.trees["command"], self.trees["actual"])
        self.feedback_pairs = pairs(self.trees["command"], self.trees["feedback"])

    @staticmethod
    def _parts(tree: Leaf | Branch) -> tuple[Leaf | Branch, ...]:
        return tree.parts if isinstance(tree, Branch) else ()

    def define(self, hook: Callable[..., Any], args: str, body: list[ast.stmt]) -> None:
        """Adds a function and links it to a hook."""
        self.module.link(hook, self.module.generated(hook.__name__, args.split(), body))

    # ---- places
    def places(self) -> None:
        """Parameters, state and signals from and to their vectors, for one run and for lanes."""
        m = self.module
        m.link(hooks.LoopState, m.named_tuple(self.plan.state.tree.type))  # type: ignore[union-attr]
        m.link(hooks.Signals, m.named_tuple(type(self.plan.signals["_all"])))

        def one(vector: str, arrays_vector: str) -> Callable[[Leaf], ast.expr]:
            return lambda x: self.array_at(x, arrays_vector) if x.kind == "array" else cast(x, item(vector, x.at))

        def lane(vector: str) -> Callable[[Leaf], ast.expr]:
            return lambda x: (
                item(f"views.a{x.at}", "lane") if x.kind == "array" else cast(x, item(vector, x.at, "lane"))
            )

        def cast(x: Leaf, value: ast.expr) -> ast.expr:
            if is_absent(x):
                return ast.Constant(0.0)
            if x.kind == "float":
                return value
            return call("int", value) if x.kind == "int" else ast.Compare(value, [ast.NotEq()], [ast.Constant(0.0)])

        params, state = self.plan.params.tree, self.plan.state.tree
        self.define(hooks.params_of, "P A", [give(body_of(params, m, one("P", "A")))])
        self.define(hooks.state_of, "S B", [give(body_of(state, m, one("S", "B")))])
        self.define(hooks.keep_state, "S s", [*self.stores(state, ("S",), "s", ""), give(ast.Constant(0))])
        self.define(hooks.lane_params, "Q views lane", [give(body_of(params, m, lane("Q")))])
        self.define(hooks.lane_state, "Z views lane", [give(body_of(state, m, lane("Z")))])
        kept = [s for part in self._parts(state) if part.key not in ("plant", "integrator")
                for s in self.stores(part, ("Z", "lane"), "s", "")]  # fmt: skip
        self.define(hooks.keep_lane, "Z lane s", [*kept, give(ast.Constant(0))])
        moved = self.stores(self.state_parts["plant"], ("Z", "lane"), "plant", "plant.")
        memory = self.state_parts["integrator"]
        moved.append(put("Z", (memory.at, "lane"), "memory"))  # type: ignore[union-attr]
        self.define(hooks.keep_lane_plant, "Z lane plant memory", [*moved, give(ast.Constant(0))])
        self.lane_arrays("param_views", "fill_params", "set_param", self.plan.params)
        self.lane_arrays("state_views", "fill_states", "set_state", self.plan.state)
        self.drives()
        self.row()
        self.soundness()
        m.constants.update(
            PARAMS=max(1, len(self.plan.params.scalars)), STATES=max(1, len(self.plan.state.scalars)),
            ROW=len(self.plan.columns),
        )  # fmt: skip

    @staticmethod
    def array_at(x: Leaf, vector: str, width: int = 1) -> ast.expr:
        """The view of one array in its vector."""
        low, high = ast.Constant(x.at * width), ast.Constant((x.at + x.size) * width)
        stretch = ast.Subscript(name(vector), ast.Slice(low, high), ast.Load())
        shape = [ast.Constant(n) for n in ((width, *x.shape) if width > 1 else x.shape)]
        return ast.Call(ast.Attribute(stretch, "reshape", ast.Load()), shape, [])  # type: ignore[arg-type]

    def stores(self, node: Leaf | Branch, target: tuple[str, ...], source: str, prefix: str) -> list[ast.stmt]:
        """Writes of every scalar below a node into a vector (of one run) or a matrix (of lanes)."""
        array, *lane = target
        return [
            put(array, (x.at, *lane), times(ast.Constant(1.0), f"{source}.{x.key.removeprefix(prefix)}"))
            for x in scalar_leaves(node)
            if not is_absent(x)
        ]

    def lane_arrays(self, views: str, fill: str, change: str, layout: Layout) -> None:
        """Array leaves in lanes: their views, and how they are filled."""
        m, width = self.module, ast.Constant(LANES)
        if layout.arrays:
            cls = type(
                bundle(views.title().replace("_", ""), {f"a{x.at}": np.zeros((1, *x.shape)) for x in layout.arrays})
            )
            made: ast.expr = call(m.named_tuple(cls), *(self.array_at(x, "V", LANES) for x in layout.arrays))
        else:
            made = ast.Constant(0.0)
        self.define(getattr(hooks, views), "V", [give(made)])
        copies: list[ast.stmt] = []
        sets: list[ast.stmt] = []
        for x in layout.arrays:
            at, size = ast.Constant(x.at), ast.Constant(x.size)
            copies.append(do(call(m.function(lanes.copy_lane), "target", "source", at, size, "lane", width)))
            sets.append(do(call(m.function(lanes.set_lane), "target", at, size, "place", "lane", width, "value")))
        self.define(getattr(hooks, fill), "target source lane", [*copies, give(ast.Constant(0))])
        self.define(getattr(hooks, change), "target place lane value", [*sets, give(ast.Constant(0))])

    def drives(self) -> None:
        """What goes from the sampling stage to the plant stage of a lane."""
        places: dict[tuple[str, str], int] = {}
        for root in ("applied", "load"):
            for x in leaves(self.trees[root]):
                places[root, x.key] = len(places)
        writes = [put("U", (i, "lane"), under(*k)) for k, i in places.items()]
        self.define(hooks.keep_drive, "U lane applied load", [*writes, give(ast.Constant(0))])
        for root, hook in (("applied", hooks.lane_applied), ("load", hooks.lane_load)):
            made = body_of(self.trees[root], self.module, lambda x, r=root: item("U", places[r, x.key], "lane"))  # type: ignore[misc]
            self.define(hook, "U lane", [give(made)])
        self.module.constants["DRIVES"] = len(places)

    def row(self) -> None:
        """All that can be recorded in a period."""
        columns: dict[str, ast.expr] = {"time": name("t")}
        for signal in ("command", "feedback", "output", "applied", "actual", "load"):
            shown = "disturbance" if signal == "load" else signal
            for x in leaves(self.trees[signal]):
                columns[under(shown, x.key)] = name(under(f"x.{signal}", x.key))
        for title, other, found in (
            ("error", "feedback", self.feedback_pairs),
            ("true_error", "actual", self.actual_pairs),
        ):
            for pair in found:
                columns[f"{title}{pair.suffix}"] = self.difference(other, pair)
        for x in scalar_leaves(self.plan.state.tree):
            if x.key.split(".")[0] in SLOTS and "." in x.key:
                columns[x.key] = name(f"s.{x.key}")
        self.plan.columns = list(columns)
        writes = [put("R", (i, "lane"), times(ast.Constant(1.0), v)) for i, v in enumerate(columns.values())]
        self.define(hooks.keep_row, "R lane x s t", [*writes, give(ast.Constant(0))])

    @staticmethod
    def difference(other: str, pair: Pair) -> ast.expr:
        """Command less another signal."""
        return minus(under("x.command", pair.command), under(f"x.{other}", pair.other))

    def soundness(self) -> None:
        """What must be finite, and what must lie within the bound."""
        m, largest = self.module, ast.Constant(LARGEST)
        parts: list[ast.expr] = []
        for slot in (*TAIL, "plant"):
            node = self.state_parts[slot]
            for x in leaves(node) if isinstance(node, Branch) else []:
                if x.kind in LIMITS:
                    parts.append(within(name(f"s.{x.key}"), ast.Constant(LIMITS[x.kind])))
                elif x.kind == "array":
                    whole: ast.expr = name(f"s.{x.key}")
                    if len(x.shape) > 1:  # one long loop: LLVM unrolls short rows before it could make vectors of them
                        whole = ast.Call(ast.Attribute(whole, "reshape", ast.Load()), [ast.Constant(x.size)], [])
                    parts.append(call(m.function(lanes.sound1), whole))
        self.define(hooks.state_sound, "s", [give(both(parts) if parts else ast.Constant(True))])
        seen = [within(name(under("x.output", x.key)), largest) for x in leaves(self.trees["output"])]
        seen += [within(name(under("x.actual", x.key)), name("bound")) for x in leaves(self.trees["actual"])]
        self.define(hooks.signals_sound, "x bound", [give(both(seen))])

        def flushed(x: Leaf) -> ast.expr:
            here = name(f"plant.{x.key.removeprefix('plant.')}")
            return call(m.function(portable.flush), here) if x.kind == "float" else here

        self.define(hooks.settled, "plant", [give(body_of(self.state_parts["plant"], m, flushed))])

    # ---- blocks
    def step(self, block: Block, state: str = "s", params: str = "p", **signals: str) -> ast.expr:
        """A call of a block's step; ``signals`` renames what it takes."""
        slot = next((k for k, b in self.plan.blocks.items() if b is block), "")
        held = next((x for x in self._parts(self.plan.params.tree) if x.key == slot), None)
        params_type = held.type if isinstance(held, Branch) else type(block.params)  # what a block prepares has its own
        for cls, arg in ((params_type, "p"), (type(block.state), "s")):
            if cls is not type(None):
                self.module.arguments.setdefault((id(block.step), arg), cls)
        lead = [params] * (block.params is not None) + [state] * (block.state is not None)
        rest = [signals.get(n, n) for n in block.signals]
        return call(self.module.callable(block.step), *lead, *rest)

    def slot(self, slot: str, args: str, default: ast.expr | str) -> None:
        """Links the block of a slot, or what an empty slot does."""
        block = self.plan.blocks[slot]
        if block is None:
            body = [give(ast.Constant(0.0), default)]
        elif block.state is not None:
            body = [give(self.step(block))]
        else:
            body = [give(ast.Constant(0.0), self.step(block))]
        self.define(getattr(hooks, slot), args, body)

    def blocks(self) -> None:
        """The seven slots and the metrics."""
        self.slot("reference", "p s t dt noise", ast.Constant(0.0))
        self.slot("disturbance", "p s t dt noise", ast.Constant(0.0))
        self.slot("output_disturbance", "p s t dt noise", ast.Constant(0.0))
        self.slot("sensor", "p s actual t dt noise", "actual")
        self.slot("controller", "p s command feedback t dt", "command")
        self.slot("actuator", "p s output t dt", "output")
        self.output()
        self.disturbed()
        self.metrics()
        self.delays()
        plant = self.plan.blocks["plant"]
        assert plant is not None
        u, before = self.drive(plant)
        if "dt" in plant.signals:
            self.define(hooks.plant_step, "p s memory u load t dt", [*before, give(self.step(plant, u=u), "memory")])
            return
        self.define(hooks.derivative, "p s u load t", [*before, give(self.step(plant, u=u))])
        if not self.plan.continuous:
            self.integrator(plant)

    def drive(self, plant: Block) -> tuple[str, list[ast.stmt]]:
        """The name under which the plant gets its input, with the load added where it does not take it itself."""
        if "load" in plant.signals or self.plan.blocks["disturbance"] is None:
            return "u", []
        applied, load = self.trees["applied"], self.trees["load"]
        theirs = leaves(load)
        if len(theirs) != 1 and [x.key for x in theirs] != [x.key for x in leaves(applied)]:
            raise BlockError(
                f"{plant.name}: the disturbance has {len(theirs)} numbers, the input {len(leaves(applied))}; "
                "give them the same NamedTuple, or let the plant take 'load'"
            )

        def summed(x: Leaf) -> ast.expr:
            first = x is leaves(applied)[0]
            if len(theirs) == 1 and not first:
                return name(under("u", x.key))
            return add(under("u", x.key), under("load", theirs[0].key if len(theirs) == 1 else x.key))

        return "driven", [assign("driven", body_of(applied, self.module, summed))]

    def output(self) -> None:
        """What the plant shows the sensor."""
        plant = self.plan.blocks["plant"]
        assert plant is not None
        shown = plant.output or plant.state._fields[0]
        if callable(shown):
            names = shown.__code__.co_varnames[: shown.__code__.co_argcount]
            self.module.arguments[id(shown), "s"] = type(plant.state)
            made = call(self.module.callable(shown), *names)
        else:
            made = name(f"s.{shown}")
        self.define(hooks.plant_output, "p s", [give(made)])

    def disturbed(self) -> None:
        """Adds the output disturbance to the first number of the plant's output."""
        if self.plan.blocks["output_disturbance"] is None:
            self.define(hooks.disturbed, "actual offset", [give("actual")])
            return
        tree = self.trees["actual"]
        first = leaves(tree)[0]

        def shifted(x: Leaf) -> ast.expr:
            here = under("actual", x.key)
            return add(here, "offset") if x is first else name(here)

        self.define(hooks.disturbed, "actual offset", [give(body_of(tree, self.module, shifted))])

    def metrics(self) -> None:
        """All metrics as one function, and their values as another."""
        main, measured = self.actual_pairs[0], self.feedback_pairs[0]
        body: list[ast.stmt] = [
            assign("error", minus(under("command", main.command), under("actual", main.other))),
        ]
        names = {
            "command": under("command", main.command),
            "actual": under("actual", main.other),
            "feedback": under("feedback", measured.other),
            "output": under("output", leaves(self.trees["output"])[0].key),
        }
        parts, values = [], []
        for i, (key, block) in enumerate(self.plan.metrics.items()):
            renamed = {k: names.get(k, k) for k in block.signals}
            parts.append(self.step(block, state=f"s.{key}", params=f"p.{key}", **renamed))
            value: Any = block.output
            lead = [f"p.{key}"] * (block.params is not None) + [f"s.metrics.{key}"]
            lead = [x.replace("p.", "p.metrics.", 1) if x.startswith("p.") else x for x in lead]
            values.append(put("M", ("run", i), call(self.module.callable(value), *lead)))
        kept = self.state_parts["metrics"]
        made = call(self.module.named_tuple(kept.type), *parts) if isinstance(kept, Branch) else ast.Constant(0.0)
        self.define(hooks.metrics, "p s command actual feedback output t dt", [*body, give(made)])
        self.define(hooks.keep_metrics, "M run p s", [*values, give(ast.Constant(0))])

    def delays(self) -> None:
        """The two delay lines; without delay they vanish."""
        whole, part = self.plan.sent
        applied, shown = self.trees["applied"], self.trees["actual"]
        if (whole, part) == (0, 0):
            self.define(hooks.send, "line applied k", [give(ast.Constant(0))])
            self.define(hooks.sent, "line applied k j substeps", [give("applied")])
        else:
            slots = ast.Constant(whole + 2)
            rows = [
                put("line", (ast.BinOp(name("k"), ast.Mod(), slots), i), under("applied", x.key))
                for i, x in enumerate(leaves(applied))
            ]
            self.define(hooks.send, "line applied k", [*rows, give(ast.Constant(0))])
            late = ast.IfExp(
                ast.Compare(name("j"), [ast.Lt()], [ast.Constant(part)]), ast.Constant(whole + 1), ast.Constant(whole)
            )
            index = {x.key: i for i, x in enumerate(leaves(applied))}
            before = ast.Compare(name("n"), [ast.Lt()], [ast.Constant(0)])

            def held(x: Leaf) -> ast.expr:
                return ast.IfExp(before, ast.Constant(0.0), item("line", "place", index[x.key]))

            place = ast.IfExp(before, ast.Constant(0), ast.BinOp(name("n"), ast.Mod(), slots))
            body = [assign("n", minus("k", late)), assign("place", place), give(body_of(applied, self.module, held))]
            self.define(hooks.sent, "line applied k j substeps", body)
        if self.plan.seen == 0:
            self.define(hooks.watch, "line p plant n", [give(ast.Constant(0))])
            self.define(hooks.seen, "line actual k substeps", [give("actual")])
            return
        slots = ast.Constant(self.plan.seen + 1)
        at = ast.BinOp(name("n"), ast.Mod(), slots)
        shown_call = call(self.module.names[id(hooks.plant_output)], "p", "plant")
        rows = [put("line", (at, i), under("actual", x.key)) for i, x in enumerate(leaves(shown))]
        self.define(hooks.watch, "line p plant n", [assign("actual", shown_call), *rows, give(ast.Constant(0))])
        index = {x.key: i for i, x in enumerate(leaves(shown))}
        past = minus("n", ast.Constant(self.plan.seen))
        start = ast.IfExp(
            ast.Compare(name("past"), [ast.Lt()], [ast.Constant(0)]),
            ast.Constant(0),
            ast.BinOp(name("past"), ast.Mod(), slots),
        )
        back = body_of(shown, self.module, lambda x: item("line", "place", index[x.key]))
        first = [assign("n", times("k", "substeps")), *rows, assign("past", past), assign("place", start), give(back)]
        self.define(hooks.seen, "line actual k substeps", first)

    # ---- integrators
    def integrator(self, plant: Block) -> None:
        """Links the integrator of a plant that gives its derivative."""
        tree = self.state_parts["plant"]
        self.vector(tree, scalar_leaves(tree), "plant.")
        self.module.constants["TIMED"] = "t" in plant.signals
        if self.plan.method != "rk4":
            f = self.module.names[id(hooks.derivative)]
            spread = self.module.names[id(hooks.spread)]
            here = call(self.module.names[id(hooks.gathered)], "s", "x")
            body = [do(call(spread, call(f, "p", here, "u", "load", "t"), "f")), give(ast.Constant(0))]
            self.define(hooks.rates, "p s u load t x f", body)
            self.jacobian(plant)
        else:
            self.steps(tree)
        self.module.link(hooks.plant_step, self.module.function(METHODS[self.plan.method]))

    def steps(self, tree: Leaf | Branch) -> None:
        """``along`` and ``weighted`` over the plant's state."""

        def moved(x: Leaf, rate: Callable[[str], ast.expr]) -> ast.expr:
            key = x.key.removeprefix("plant.")
            if x.kind != "float":
                return name(f"s.{key}")
            return add(f"s.{key}", times("h", rate(key)))

        def slope(key: str) -> ast.expr:
            two = ast.Constant(2.0)
            return add(add(add(f"k1.{key}", times(two, name(f"k2.{key}"))), times(two, name(f"k3.{key}"))), f"k4.{key}")

        self.define(
            hooks.along, "s h k", [give(body_of(tree, self.module, lambda x: moved(x, lambda k: name(f"k.{k}"))))]
        )
        self.define(hooks.weighted, "s h k1 k2 k3 k4", [give(body_of(tree, self.module, lambda x: moved(x, slope)))])

    def vector(self, tree: Leaf | Branch, parts: list[Leaf], prefix: str) -> None:
        """The integrated state as a vector, and back."""
        order = {x.key: i for i, x in enumerate(parts)}
        for x in parts:
            if x.kind != "float":
                raise BlockError(f"the state {x.key} is {x.kind}; an integrated state holds floats only")
        writes = [put("x", (0, i), f"s.{k.removeprefix(prefix)}") for k, i in order.items()]
        self.define(hooks.spread, "s x", [*writes, give(ast.Constant(0))])

        def back(x: Leaf) -> ast.expr:
            return item("x", 0, order[x.key]) if x.key in order else name(f"s.{x.key.removeprefix(prefix)}")

        self.define(hooks.gathered, "s x", [give(body_of(tree, self.module, back))])
        self.module.constants["ORDER"] = len(parts)

    def jacobian(self, plant: Block) -> None:
        """The plant's own Jacobian where it has one, else forward differences."""
        if plant.jacobian is None or self.plan.continuous:
            self.module.link(hooks.jacobian, self.module.function(rodas.difference_jacobian))
            return
        wanted = plant.jacobian.__code__.co_varnames[: plant.jacobian.__code__.co_argcount]
        rows = call(self.module.callable(plant.jacobian), *("here" if n == "s" else n for n in wanted))
        n = int(self.module.constants["ORDER"])
        here = call(self.module.names[id(hooks.gathered)], "s", "x")

        cells = [[f"j{i}_{j}" for j in range(n)] for i in range(n)]
        targets: list[ast.expr] = [ast.Tuple([ast.Name(c, ast.Store()) for c in row], ast.Store()) for row in cells]
        writes = [put("jac", (i, j), cells[i][j]) for i in range(n) for j in range(n)]
        taken = ast.Assign([ast.Tuple(targets, ast.Store())], rows)
        body = [assign("here", here), taken, *writes, give(ast.Constant(0))]
        self.define(hooks.jacobian, "p s u load t x f jac", body)

    def continuous(self) -> None:
        """A loop without period: controller and plant in one vector."""
        mine, theirs = self.state_parts["controller"], self.state_parts["plant"]
        parts = [*(scalar_leaves(mine) if isinstance(mine, Branch) else []), *scalar_leaves(theirs)]
        self.vector(self.plan.state.tree, parts, "")
        writes = []
        for i, x in enumerate(parts):
            writes.append(put("f", (0, i), x.key))
        self.define(hooks.spread_rates, "s controller plant f", [*writes, give(ast.Constant(0))])
        self.module.constants["TIMED"] = True

        def kept(x: Leaf) -> ast.expr:
            return name("h") if x.key == "integrator" else name(f"s.{x.key}")

        self.define(hooks.remembered, "s h", [give(body_of(self.plan.state.tree, self.module, kept))])
        plant = self.plan.blocks["plant"]
        assert plant is not None
        self.module.link(hooks.rates, self.module.function(continuous.continuous_rates))
        self.jacobian(plant)

    def split(self) -> list[tuple[str, Leaf]]:
        """Adds the entries ``read`` and ``write``: the loop without its controller, for a machine to be simulated by.

        Returns:
            what stands in their vector ``X``: the leaves of command, feedback, load and output, with their signals.
        """
        self.blocks()
        self.places()
        held = [(s, x) for s in ("command", "feedback", "load", "output") for x in leaves(self.trees[s])]
        at = {(s, x.key): i for i, (s, x) in enumerate(held)}
        writes = [put("X", (at[s, x.key],), under(s, x.key)) for s, x in held if s != "output"]
        self.define(hooks.keep_sensed, "X command feedback load", [*writes, give(ast.Constant(0))])
        for signal, hook in (("output", hooks.given_output), ("load", hooks.given_load)):
            made = body_of(self.trees[signal], self.module, lambda x, s=signal: item("X", at[s, x.key]))  # type: ignore[misc]
            self.define(hook, "X", [give(made)])
        self.module.entry(single.read, "read")
        self.module.entry(single.write, "write")
        return held

    def link(self) -> Module:
        """The whole module."""
        self.blocks()
        self.places()
        if self.plan.continuous:
            self.continuous()
            self.module.entry(continuous.continuous, "single")
            return self.module
        self.module.entry(single.single, "single")
        return self.module

    def lanes(self) -> None:
        """Adds the entries for batches."""
        for recording, title in ((False, "lanes"), (True, "lanes_recorded")):
            self.module.constants["RECORDING"] = recording
            self.module.entry(lanes.lanes, title)
