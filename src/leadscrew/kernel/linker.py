"""Links a loop's blocks into the holes of the drivers and gives the generated module."""

from __future__ import annotations

import ast
from collections.abc import Callable
from typing import Any

from leadscrew.kernel.block import Block
from leadscrew.kernel.drivers import continuous, fixed, holes, lanes, rodas, single, split
from leadscrew.kernel.errors import BlockError
from leadscrew.kernel.frame import under
from leadscrew.kernel.layout import Branch, Leaf, leaves
from leadscrew.kernel.module import Module
from leadscrew.kernel.places import Places
from leadscrew.kernel.plan import LANES, LARGEST, Plan, body_of, scalar_leaves
from leadscrew.kernel.syntax import add, assign, call, do, give, item, minus, name, put, times

METHODS: dict[str, Callable[..., Any]] = {"rk4": fixed.rk4, "sdirk3": fixed.sdirk3, "rodas": rodas.rodas}
"""Integrators by name; a plant that takes ``dt`` brings its own step."""


class Linker(Places):
    """Fills the holes that call blocks, and puts the drivers together."""

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
        self.define(getattr(holes, slot), args, body)

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
            self.define(holes.plant_step, "p s memory u load t dt", [*before, give(self.step(plant, u=u), "memory")])
            return
        self.define(holes.derivative, "p s u load t", [*before, give(self.step(plant, u=u))])
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
        self.define(holes.plant_output, "p s", [give(made)])

    def disturbed(self) -> None:
        """Adds the output disturbance to the first number of the plant's output."""
        if self.plan.blocks["output_disturbance"] is None:
            self.define(holes.disturbed, "actual offset", [give("actual")])
            return
        tree = self.trees["actual"]
        first = leaves(tree)[0]

        def shifted(x: Leaf) -> ast.expr:
            here = under("actual", x.key)
            return add(here, "offset") if x is first else name(here)

        self.define(holes.disturbed, "actual offset", [give(body_of(tree, self.module, shifted))])

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
        self.define(holes.metrics, "p s command actual feedback output t dt", [*body, give(made)])
        self.define(holes.keep_metrics, "M run p s", [*values, give(ast.Constant(0))])

    def delays(self) -> None:
        """The two delay lines; without delay they vanish."""
        whole, part = self.plan.sent
        applied, shown = self.trees["applied"], self.trees["actual"]
        if (whole, part) == (0, 0):
            self.define(holes.send, "line applied k", [give(ast.Constant(0))])
            self.define(holes.sent, "line applied k j substeps", [give("applied")])
        else:
            slots = ast.Constant(whole + 2)
            rows = [
                put("line", (ast.BinOp(name("k"), ast.Mod(), slots), i), under("applied", x.key))
                for i, x in enumerate(leaves(applied))
            ]
            self.define(holes.send, "line applied k", [*rows, give(ast.Constant(0))])
            late = ast.IfExp(
                ast.Compare(name("j"), [ast.Lt()], [ast.Constant(part)]), ast.Constant(whole + 1), ast.Constant(whole)
            )
            index = {x.key: i for i, x in enumerate(leaves(applied))}
            before = ast.Compare(name("n"), [ast.Lt()], [ast.Constant(0)])

            def held(x: Leaf) -> ast.expr:
                return ast.IfExp(before, ast.Constant(0.0), item("line", "place", index[x.key]))

            place = ast.IfExp(before, ast.Constant(0), ast.BinOp(name("n"), ast.Mod(), slots))
            body = [assign("n", minus("k", late)), assign("place", place), give(body_of(applied, self.module, held))]
            self.define(holes.sent, "line applied k j substeps", body)
        if self.plan.seen == 0:
            self.define(holes.watch, "line p plant n", [give(ast.Constant(0))])
            self.define(holes.seen, "line actual k substeps", [give("actual")])
            return
        slots = ast.Constant(self.plan.seen + 1)
        at = ast.BinOp(name("n"), ast.Mod(), slots)
        shown_call = call(self.module.names[id(holes.plant_output)], "p", "plant")
        rows = [put("line", (at, i), under("actual", x.key)) for i, x in enumerate(leaves(shown))]
        self.define(holes.watch, "line p plant n", [assign("actual", shown_call), *rows, give(ast.Constant(0))])
        index = {x.key: i for i, x in enumerate(leaves(shown))}
        past = minus("n", ast.Constant(self.plan.seen))
        start = ast.IfExp(
            ast.Compare(name("past"), [ast.Lt()], [ast.Constant(0)]),
            ast.Constant(0),
            ast.BinOp(name("past"), ast.Mod(), slots),
        )
        back = body_of(shown, self.module, lambda x: item("line", "place", index[x.key]))
        first = [assign("n", times("k", "substeps")), *rows, assign("past", past), assign("place", start), give(back)]
        self.define(holes.seen, "line actual k substeps", first)

    # ---- integrators
    def integrator(self, plant: Block) -> None:
        """Links the integrator of a plant that gives its derivative."""
        tree = self.state_parts["plant"]
        self.vector(tree, scalar_leaves(tree), "plant.")
        self.module.constants["TIMED"] = "t" in plant.signals
        if self.plan.method != "rk4":
            f = self.module.names[id(holes.derivative)]
            spread = self.module.names[id(holes.spread)]
            here = call(self.module.names[id(holes.gathered)], "s", "x")
            body = [do(call(spread, call(f, "p", here, "u", "load", "t"), "f")), give(ast.Constant(0))]
            self.define(holes.rates, "p s u load t x f", body)
            self.jacobian(plant)
        else:
            self.steps(tree)
        self.module.link(holes.plant_step, self.module.function(METHODS[self.plan.method]))

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
            holes.along, "s h k", [give(body_of(tree, self.module, lambda x: moved(x, lambda k: name(f"k.{k}"))))]
        )
        self.define(holes.weighted, "s h k1 k2 k3 k4", [give(body_of(tree, self.module, lambda x: moved(x, slope)))])

    def vector(self, tree: Leaf | Branch, parts: list[Leaf], prefix: str) -> None:
        """The integrated state as a vector, and back."""
        order = {x.key: i for i, x in enumerate(parts)}
        for x in parts:
            if x.kind != "float":
                raise BlockError(f"the state {x.key} is {x.kind}; an integrated state holds floats only")
        writes = [put("x", (0, i), f"s.{k.removeprefix(prefix)}") for k, i in order.items()]
        self.define(holes.spread, "s x", [*writes, give(ast.Constant(0))])

        def back(x: Leaf) -> ast.expr:
            return item("x", 0, order[x.key]) if x.key in order else name(f"s.{x.key.removeprefix(prefix)}")

        self.define(holes.gathered, "s x", [give(body_of(tree, self.module, back))])
        self.module.constants["ORDER"] = len(parts)

    def jacobian(self, plant: Block) -> None:
        """The plant's own Jacobian where it has one, else forward differences."""
        if plant.jacobian is None or self.plan.continuous:
            self.module.link(holes.jacobian, self.module.function(rodas.difference_jacobian))
            return
        wanted = plant.jacobian.__code__.co_varnames[: plant.jacobian.__code__.co_argcount]
        rows = call(self.module.callable(plant.jacobian), *("here" if n == "s" else n for n in wanted))
        n = int(self.module.constants["ORDER"])
        here = call(self.module.names[id(holes.gathered)], "s", "x")

        cells = [[f"j{i}_{j}" for j in range(n)] for i in range(n)]
        targets: list[ast.expr] = [ast.Tuple([ast.Name(c, ast.Store()) for c in row], ast.Store()) for row in cells]
        writes = [put("jac", (i, j), cells[i][j]) for i in range(n) for j in range(n)]
        taken = ast.Assign([ast.Tuple(targets, ast.Store())], rows)
        body = [assign("here", here), taken, *writes, give(ast.Constant(0))]
        self.define(holes.jacobian, "p s u load t x f jac", body)

    def continuous(self) -> None:
        """A loop without period: controller and plant in one vector."""
        mine, theirs = self.state_parts["controller"], self.state_parts["plant"]
        parts = [*(scalar_leaves(mine) if isinstance(mine, Branch) else []), *scalar_leaves(theirs)]
        self.vector(self.plan.state.tree, parts, "")
        writes = []
        for i, x in enumerate(parts):
            writes.append(put("f", (0, i), x.key))
        self.define(holes.spread_rates, "s controller plant f", [*writes, give(ast.Constant(0))])
        self.module.constants["TIMED"] = True

        def kept(x: Leaf) -> ast.expr:
            return name("h") if x.key == "integrator" else name(f"s.{x.key}")

        self.define(holes.remembered, "s h", [give(body_of(self.plan.state.tree, self.module, kept))])
        plant = self.plan.blocks["plant"]
        assert plant is not None
        self.module.link(holes.rates, self.module.function(continuous.continuous_rates))
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
        self.define(holes.keep_sensed, "X command feedback load", [*writes, give(ast.Constant(0))])
        for signal, hole in (("output", holes.given_output), ("load", holes.given_load)):
            made = body_of(self.trees[signal], self.module, lambda x, s=signal: item("X", at[s, x.key]))  # type: ignore[misc]
            self.define(hole, "X", [give(made)])
        self.module.entry(split.read, "read")
        self.module.entry(split.write, "write")
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


__all__ = ["LANES", "LARGEST", "METHODS", "Linker", "Plan"]
