"""Parameters, state and signals of a loop from and to their flat vectors: for one run, for lanes, for recording."""

from __future__ import annotations

import ast
from collections.abc import Callable

import numpy as np

from leadscrew.kernel import portable
from leadscrew.kernel.drivers import arrays, holes
from leadscrew.kernel.frame import SLOTS, Pair, bundle, under
from leadscrew.kernel.layout import Branch, Layout, Leaf, leaves
from leadscrew.kernel.plan import LANES, LARGEST, LIMITS, TAIL, Linking, body_of, is_absent, scalar_leaves
from leadscrew.kernel.syntax import both, call, do, give, item, minus, name, put, times, within


class Places(Linking):
    """Fills the holes that move numbers."""

    # ---- places
    def places(self) -> None:
        """Parameters, state and signals from and to their vectors, for one run and for lanes."""
        m = self.module
        m.link(holes.LoopState, m.named_tuple(self.plan.state.tree.type))  # type: ignore[union-attr]
        m.link(holes.Signals, m.named_tuple(type(self.plan.signals["_all"])))

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
        self.define(holes.params_of, "P A", [give(body_of(params, m, one("P", "A")))])
        self.define(holes.state_of, "S B", [give(body_of(state, m, one("S", "B")))])
        self.define(holes.keep_state, "S s", [*self.stores(state, ("S",), "s", ""), give(ast.Constant(0))])
        self.define(holes.lane_params, "Q views lane", [give(body_of(params, m, lane("Q")))])
        self.define(holes.lane_state, "Z views lane", [give(body_of(state, m, lane("Z")))])
        kept = [s for part in self._parts(state) if part.key not in ("plant", "integrator")
                for s in self.stores(part, ("Z", "lane"), "s", "")]  # fmt: skip
        self.define(holes.keep_lane, "Z lane s", [*kept, give(ast.Constant(0))])
        moved = self.stores(self.state_parts["plant"], ("Z", "lane"), "plant", "plant.")
        memory = self.state_parts["integrator"]
        moved.append(put("Z", (memory.at, "lane"), "memory"))  # type: ignore[union-attr]
        self.define(holes.keep_lane_plant, "Z lane plant memory", [*moved, give(ast.Constant(0))])
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
        self.define(getattr(holes, views), "V", [give(made)])
        copies: list[ast.stmt] = []
        sets: list[ast.stmt] = []
        for x in layout.arrays:
            at, size = ast.Constant(x.at), ast.Constant(x.size)
            copies.append(do(call(m.function(arrays.copy_lane), "target", "source", at, size, "lane", width)))
            sets.append(do(call(m.function(arrays.set_lane), "target", at, size, "place", "lane", width, "value")))
        self.define(getattr(holes, fill), "target source lane", [*copies, give(ast.Constant(0))])
        self.define(getattr(holes, change), "target place lane value", [*sets, give(ast.Constant(0))])

    def drives(self) -> None:
        """What goes from the sampling stage to the plant stage of a lane."""
        places: dict[tuple[str, str], int] = {}
        for root in ("applied", "load"):
            for x in leaves(self.trees[root]):
                places[root, x.key] = len(places)
        writes = [put("U", (i, "lane"), under(*k)) for k, i in places.items()]
        self.define(holes.keep_drive, "U lane applied load", [*writes, give(ast.Constant(0))])
        for root, hole in (("applied", holes.lane_applied), ("load", holes.lane_load)):
            made = body_of(self.trees[root], self.module, lambda x, r=root: item("U", places[r, x.key], "lane"))  # type: ignore[misc]
            self.define(hole, "U lane", [give(made)])
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
        self.define(holes.keep_row, "R lane x s t", [*writes, give(ast.Constant(0))])

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
                    parts.append(call(m.function(arrays.sound1), whole))
        self.define(holes.state_sound, "s", [give(both(parts) if parts else ast.Constant(True))])
        seen = [within(name(under("x.output", x.key)), largest) for x in leaves(self.trees["output"])]
        seen += [within(name(under("x.actual", x.key)), name("bound")) for x in leaves(self.trees["actual"])]
        self.define(holes.signals_sound, "x bound", [give(both(seen))])

        def flushed(x: Leaf) -> ast.expr:
            here = name(f"plant.{x.key.removeprefix('plant.')}")
            return call(m.function(portable.flush), here) if x.kind == "float" else here

        self.define(holes.settled, "plant", [give(body_of(self.state_parts["plant"], m, flushed))])
