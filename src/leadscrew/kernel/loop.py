"""The loop: reference, sensor, controller, actuator, plant and disturbances around one control period."""

from __future__ import annotations

import math
import platform
import time
import warnings
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.kernel import validate
from leadscrew.kernel.block import Block, takes
from leadscrew.kernel.by_position import by_position
from leadscrew.kernel.engines import ENGINES
from leadscrew.kernel.frame import SLOTS, Clock, as_floats, bundle
from leadscrew.kernel.layout import Layout
from leadscrew.kernel.linker import LARGEST, METHODS, Plan
from leadscrew.kernel.module import Module
from leadscrew.kernel.notes import DivergenceWarning, RunWarning, notes
from leadscrew.kernel.parameters import ParameterSpec, entries, nearest
from leadscrew.kernel.probe import example_signals
from leadscrew.kernel.program import Program, programs
from leadscrew.kernel.trees import treework
from leadscrew.kernel.units import UnitWarning, mismatches
from leadscrew.kernel.views import view
from leadscrew.util.errors import NameUnknown, ValueRefused, entry_point
from leadscrew.util.escape import checked_line
from leadscrew.util.frames import warning_level

if TYPE_CHECKING:
    from control import TimeResponseData

    from leadscrew.analysis.linearization import Linearization
    from leadscrew.analysis.stability.margins import Margins
    from leadscrew.kernel.batch import Batch
    from leadscrew.kernel.live import Live
    from leadscrew.kernel.run import Run

RECORDED = ("command", "feedback", "output", "applied", "actual", "disturbance", "error", "true_error")
"""What a run records by default."""


@entry_point
class Loop:
    """A closed loop, ready to run on any engine.

    In every control period, at its start: the reference gives the command, the plant's output (with the output
    disturbance, after the transport delay) goes through the sensor, the controller computes its output, the actuator
    limits it; then, after the computational delay, it is held over the plant for one period, in ``substeps``
    integration steps, while the disturbance loads the plant.

    Args:
        reference, controller, plant: blocks.
        sensor, actuator, disturbance, output_disturbance: blocks, or nothing.
        period: control period in seconds; ``None`` makes controller and plant one continuous system.
        substeps: integration steps a period.
        method: ``rk4``, ``sdirk3`` (stiff, fixed cost) or ``rodas`` (stiff, adaptive), for plants that give a
            derivative; unless named, ``rodas`` for a plant declared ``stiff`` and ``rk4`` for any other. A plant that
            takes ``dt`` brings its own step.
        computation_delay: seconds from sampling to a new output at the plant; a multiple of period / substeps.
        transport_delay: seconds by which the sensor sees the plant late; a multiple of period / substeps.
        metrics: metric blocks by name; the standard ones unless given.
        bound: magnitude of the true output beyond which the loop counts as diverged.
        seed: of all noise.
        sample: interval between samples of a continuous loop, seconds.
        rtol, atol: tolerances of the adaptive integrator.
        engine: ``llvm`` (the default), ``c`` (where a C compiler is) or ``python``; all give the same bits.
        name: for titles and manifests.
    """

    def __init__(
        self,
        *,
        reference: Block,
        controller: Block,
        plant: Block,
        sensor: Block | None = None,
        actuator: Block | None = None,
        disturbance: Block | None = None,
        output_disturbance: Block | None = None,
        period: float | None = 1e-3,
        substeps: int = 1,
        method: str | None = None,
        computation_delay: float = 0.0,
        transport_delay: float = 0.0,
        metrics: Mapping[str, Block] | None = None,
        bound: float = LARGEST,
        seed: int = 0,
        sample: float = 1e-3,
        rtol: float = 1e-6,
        atol: float = 1e-9,
        engine: str = "llvm",
        name: str = "loop",
    ) -> None:
        given = (reference, disturbance, output_disturbance, sensor, controller, actuator, plant)
        self.blocks: dict[str, Block | None] = dict(zip(SLOTS, given, strict=True))
        validate.check_blocks(self.blocks)
        if metrics is None:
            from leadscrew.kernel.metrics import STANDARD

            metrics = STANDARD
        self.metrics = validate.check_metrics(metrics)
        self.continuous = period is None
        self.period = validate.positive("period", sample if period is None else period, "s")
        self.substeps = validate.whole("substeps", substeps, 1, 1_000_000)
        self.step = self.period / self.substeps
        if not self.continuous:
            self.blocks["controller"] = by_position(self.blocks, self.period)
        self.sent = validate.in_steps("computation_delay", computation_delay, self.step)
        self.seen = validate.in_steps("transport_delay", transport_delay, self.step)
        if method is None:
            self.method = "rodas" if self.continuous or plant.stiff else "rk4"
        else:
            self.method = validate.one_of("method", method, list(METHODS))
        self.bound = min(validate.positive("bound", bound, "in the unit of the true output"), LARGEST)
        self.seed = validate.whole("seed", seed, 0, 2**53)
        self.rtol = validate.positive("rtol", rtol, "")
        self.atol = validate.positive("atol", atol, "")
        self.engine = validate.one_of("engine", engine, list(ENGINES))
        self.name = checked_line("name", name)
        self.origin: dict[str, Any] = {}
        """How to build this loop again: study, controller, scenario and changes; goes into the manifest."""
        validate.check_continuous(self, method)
        for text in mismatches(self.blocks):
            warnings.warn(f"{self.name}: {text}", UnitWarning, stacklevel=warning_level())

    def __repr__(self) -> str:
        main = " -> ".join(b.name for s in ("reference", "controller", "plant") if (b := self.blocks[s]) is not None)
        others = ("sensor", "actuator", "disturbance", "output_disturbance")
        rest = [f"{s} {b.name}" for s in others if (b := self.blocks[s]) is not None]
        clock = "continuous" if self.continuous else f"{1e3 * self.period:g} ms"
        return f"<Loop {self.name}: {'; '.join([main, *rest, clock])}>"

    # ---- parameters
    @cached_property
    def sheet(self) -> dict[str, ParameterSpec]:
        """Every parameter by its dotted key: value, unit, range, help."""
        found: dict[str, ParameterSpec] = {}
        for slot, block in self._parametered().items():
            for entry in entries(block.params, f"{slot}."):
                found[entry.key] = entry
        return found

    def _parametered(self) -> dict[str, Block]:
        mine = {s: b for s, b in self.blocks.items() if b is not None and b.params is not None}
        return mine | {f"metrics.{k}": b for k, b in self.metrics.items() if b.params is not None}

    def using(self, changes: Mapping[str, Any] | None = None, **options: Any) -> Loop:
        """The loop with parameters changed by dotted key, and options by name: ``seed``, ``engine``, ``bound``,
        ``substeps``.

        Raises:
            NameUnknown: no such key; names the nearest.
            ValueRefused: a value of the wrong type or out of range; names value, range and key.
        """
        new = object.__new__(Loop)
        new.__dict__.update(
            {k: v for k, v in self.__dict__.items() if k not in ("sheet", "module", "signals", "program")}
        )
        new.blocks, new.metrics = dict(self.blocks), dict(self.metrics)
        may_differ = False
        for key, value in (changes or {}).items():
            slot, rest = self.split(key)
            held: dict[str, Any] = new.metrics if slot.startswith("metrics.") else new.blocks
            name = slot.removeprefix("metrics.")
            block = held[name]
            held[name] = replace(block, params=validate.replaced(block.params, rest, value, key))
            may_differ = may_differ or block.prepare is not None or block.initial is not None
        for option, value in options.items():
            if option not in ("seed", "engine", "bound", "name", "substeps"):
                can = "seed, engine, bound, name, substeps can"
                raise NameUnknown(f"a loop has no option {option!r} that can change; {can}")
            if option == "substeps":
                value, may_differ = new._stepped(value), True
            elif option == "seed":
                value = validate.whole("seed", value, 0, 2**53)
            elif option == "bound":
                value = min(validate.positive("bound", value, ""), LARGEST)
            elif option == "engine":
                value = validate.one_of("engine", value, list(ENGINES))
            else:
                value = checked_line("name", value)
            setattr(new, option, value)
        kept = self.__dict__.get("program")
        if kept is not None:
            new.__dict__["signals"] = self.signals
            if not may_differ or new.fits(kept):
                new.__dict__["program"] = kept
            else:
                del new.__dict__["signals"]
        return new

    def _stepped(self, substeps: Any) -> int:
        """Other integration steps a period, the delays as they were."""
        if self.continuous:
            raise ValueRefused("substeps: a continuous loop (period=None) chooses its steps itself")
        delays = self.sent * self.step, self.seen * self.step
        count = validate.whole("substeps", substeps, 1, 1_000_000)
        self.step = self.period / count
        names = ("computation_delay", "transport_delay")
        self.sent, self.seen = (validate.in_steps(name, d, self.step) for name, d in zip(names, delays, strict=True))
        return count

    def split(self, key: str) -> tuple[str, str]:
        """Slot and the rest of a dotted key.

        Raises:
            NameUnknown: no such key.
        """
        if key not in self.sheet:
            raise NameUnknown(f"there is no parameter {key!r}{nearest(key, list(self.sheet))}")
        parts = key.split(".")
        cut = 2 if parts[0] == "metrics" else 1
        return ".".join(parts[:cut]), ".".join(parts[cut:])

    @property
    def parameters(self) -> dict[str, Any]:
        """Every parameter's value by its dotted key."""
        return {k: e.default for k, e in self.sheet.items()}

    @property
    def integration(self) -> dict[str, Any]:
        """What integrates the plant: ``method``, ``substeps`` a period, and the tolerances where they count.

        ``method`` is ``own step`` for a plant that takes ``dt``.
        """
        plant = self.blocks["plant"]
        assert plant is not None
        method = "own step" if "dt" in plant.signals else self.method
        adaptive = method == "rodas"
        return {
            "method": method,
            "substeps": None if self.continuous else self.substeps,
            "rtol": self.rtol if adaptive else None,
            "atol": self.atol if adaptive else None,
        }

    # ---- values as the compiled loop sees them
    def prepared(self, block: Block, slot: str, duration: float = math.inf) -> Any:
        """A block's parameters as its step gets them, in a run of ``duration`` seconds."""
        return 0.0 if block.params is None else self.preparation(block, slot, duration)(block.params)

    def preparation(self, block: Block, slot: str, duration: float = math.inf) -> Callable[[Any], Any]:
        """What makes of a block's parameters those that its step gets."""
        prepare = block.prepare
        if prepare is None:
            return lambda params: params
        dt = self.step if slot == "plant" else self.period
        timed = {"duration": duration} if block.kind == "metric" and takes(prepare, "duration") else {}
        return lambda params: prepare(params, dt, **timed)

    def start_state(self, block: Block | None) -> Any:
        """A block's state at the start."""
        if block is None or block.state is None:
            return 0.0
        return block.initial(block.params) if block.initial is not None else block.state

    def values(self, duration: float = math.inf) -> tuple[Any, Any]:
        """Parameters and state of the whole loop as nested NamedTuples, for a run of ``duration`` seconds."""
        params = {s: self.prepared(b, s) if b else 0.0 for s, b in self.blocks.items()}
        measured = {k: self.prepared(b, "metrics", duration) for k, b in self.metrics.items()}
        params["metrics"] = bundle("MetricParams", measured) if measured else 0.0
        params["clock"] = Clock(self.period, self.step, self.substeps, self.seed, self.bound)
        states = {s: self.start_state(b) for s, b in self.blocks.items()}
        states["integrator"] = 0.0
        applied, shown = (len(Layout(as_floats(self.signals[k])).scalars) for k in ("applied", "actual"))
        whole = self.sent // self.substeps
        states["sent"] = np.zeros((whole + 2, applied)) if self.sent else 0.0
        states["seen"] = np.zeros((self.seen + 1, shown)) if self.seen else 0.0
        kept = {k: self.start_state(b) for k, b in self.metrics.items()}
        states["metrics"] = bundle("MetricStates", kept) if kept else 0.0
        return bundle("LoopParams", params), bundle("LoopState", states)

    @cached_property
    def module(self) -> Module:
        """The module of this loop's steps: that of a program with the same steps where there is one, else a new one."""
        known = programs.like(self.compiled_from())
        return known[0].module if known else Module()

    @cached_property
    @treework()
    def signals(self) -> dict[str, Any]:
        """An example of each signal, computed by running the steps once."""
        with self._undone_if_refused():
            return example_signals(self)

    @cached_property
    @treework()
    def program(self) -> Program:
        """The generated module of this loop; shared with the loops that differ from it in values alone."""
        with self._undone_if_refused():
            return self._linked()

    @contextmanager
    def _undone_if_refused(self) -> Iterator[None]:
        """Drops a half-filled module, so that the next attempt checks everything again."""
        try:
            yield
        except BaseException:
            self.__dict__.pop("module", None)
            raise

    def _linked(self) -> Program:
        params, state = self.values()
        plan = Plan(
            blocks=dict(self.blocks), metrics=dict(self.metrics), params=Layout(params), state=Layout(state),
            signals=self.signals, method=self.method, sent=divmod(self.sent, self.substeps), seen=self.seen,
            continuous=self.continuous, rtol=self.rtol, atol=self.atol,
        )  # fmt: skip
        key = self.compiled_from()
        known = programs.like(key)
        for program in known:
            if program.plan.layout() == plan.layout():
                return program
        program = Program(plan, Module() if self.module in [p.module for p in known] else self.module)
        programs.add(key, program)
        return program

    def compiled_from(self) -> Hashable:
        """What of a loop decides its program, but for the layout of its values."""
        blocks = tuple(
            b and (b.step, b.output, b.jacobian, b.signals, b.prepare, type(b.params), type(b.state))
            for b in [*self.blocks.values(), *self.metrics.values()]
        )
        options = (self.method, self.continuous, self.seen, self.rtol, self.atol, divmod(self.sent, self.substeps))
        return blocks, tuple(self.metrics), options

    def adopt_program(self, other: Loop) -> None:
        """Takes over the program of a loop with the same steps, where it fits: this loop is then not linked again."""
        if self.compiled_from() == other.compiled_from():
            self.__dict__["signals"] = other.signals
            if self.fits(other.program):
                self.__dict__["program"] = other.program
            else:
                del self.__dict__["signals"]

    def fits(self, program: Program) -> bool:
        """Whether a program built for another loop serves this one: the same places for the same things."""
        params, state = self.values()
        mine, theirs = (Layout(params), Layout(state)), (program.plan.params, program.plan.state)
        return all(a.keys == b.keys for a, b in zip(mine, theirs, strict=True))

    # ---- running
    def periods(self, duration: float) -> int:
        """How many control periods a duration has.

        Raises:
            ValueRefused: not positive, or shorter than one period.
        """
        duration = validate.positive("duration", duration, "s")
        n = round(duration / self.period)
        if n < 1:
            raise ValueRefused(f"duration = {duration!r} s is shorter than one period of {self.period} s")
        if n > 2**53:
            raise ValueRefused(f"duration = {duration!r} s has more than 2^53 periods of {self.period} s")
        return n

    def columns(self, record: str | Sequence[str] | None) -> list[str]:
        """The recorded columns that a list of names stands for; a root name stands for all its parts.

        Raises:
            NameUnknown: no such signal or state.
        """
        known = self.program.plan.columns
        if isinstance(record, str):
            record = [record]
        chosen = ["time"]
        for wanted in RECORDED if record is None else record:
            found = [c for c in known if c == wanted or c.startswith(f"{wanted}.")]
            if not found and wanted in SLOTS:
                raise NameUnknown(f"the {wanted} has no state that could be recorded")
            if not found:
                raise NameUnknown(f"there is no signal {wanted!r}{nearest(wanted, known)}")
            chosen += [c for c in found if c not in chosen]
        return chosen

    def run(
        self,
        duration: float,
        record: str | Sequence[str] | None = None,
        every: int = 1,
        *,
        engine: str | None = None,
        replicate: int = 0,
        run: None = None,
    ) -> Run:
        """One run from the start; ``replicate`` chooses the stream of noise, as in a batch.

        A loop that diverges stops: the run then holds the signals up to there, ``run.diverged`` says at what time and
        in what, its metrics are NaN, and a DivergenceWarning is issued. ``every=0`` records nothing.

        A loop that moves away from its target from the start, and a fuzzy controller whose inputs leave their
        universes, give a note in ``run.notes`` and a RunWarning, where command, true output, true error and
        disturbance (for a fuzzy controller the feedback too) are recorded.
        """
        from leadscrew.kernel.live import Live

        validate.renamed("run", run, "replicate")
        periods = self.periods(duration)
        done = Live(self, engine or self.engine, replicate, periods * self.period).advance(
            periods, record=record, every=every
        )
        found = notes(done)
        for note in found:
            warnings.warn(f"{self.name}: {note.message}", RunWarning, stacklevel=warning_level())
        return replace(done, notes=found) if found else done

    def start(self, *, engine: str | None = None, replicate: int = 0, run: None = None) -> Live:
        """A live loop, to be advanced a number of periods at a time.

        Its end is not known, so a metric of the last part of a run has a value only with a ``from_time`` of its own.
        """
        from leadscrew.kernel.live import Live

        validate.renamed("run", run, "replicate")
        return Live(self, engine or self.engine, replicate)

    def batch(
        self,
        duration: float,
        varied: Mapping[str, Any] | None = None,
        *,
        runs: int | None = None,
        record: str | Sequence[str] | None = (),
        every: int = 1,
        threads: int | None = None,
        first: int = 0,
        engine: str | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> Batch:
        """Many runs with parameters varied by dotted key (arrays, one value a run); metrics, and signals if asked for.

        Run ``k`` has the same bits as ``loop.using({key: values[k]}).run(duration, replicate=first + k)``.
        """
        from leadscrew.kernel.batch import run_batch

        return run_batch(self, duration, varied or {}, runs, record, every, threads, first, engine, progress)

    def sweep(self, duration: float, grid: Mapping[str, Sequence[float | str]], **options: Any) -> Batch:
        """A batch over the full grid of the values given for each key; ``batch.grid(metric)`` has the grid's shape."""
        axes = [np.asarray(v) for v in grid.values()]
        mesh = np.meshgrid(*axes, indexing="ij")
        done = self.batch(duration, {k: m.ravel() for k, m in zip(grid, mesh, strict=True)}, **options)
        done.shape = tuple(len(a) for a in axes)
        return done

    # ---- the linear view
    def linearize(
        self, time: float | None = None, state: Mapping[str, float] | None = None, *, ideal: Sequence[str] = ()
    ) -> Linearization:
        """The loop around an operating point, as python-control's ``StateSpace``: ``open_loop``, ``closed_loop``.

        The point is at rest at the start (error zero), or what a run has reached after ``time`` seconds; ``state``
        sets states of it by dotted key (``{"plant.speed": 20.0}``). A sampled loop gives discrete systems of its
        period. ``ideal=["sensor"]`` (or ``"actuator"``) leaves out a sensor that is quantised.

        Raises:
            ValueRefused: a block has no linear view there, for example a relay or a quantiser; names it.
        """
        return view("linearize")(self, time, state, ideal)

    def margins(
        self, time: float | None = None, state: Mapping[str, float] | None = None, *, ideal: Sequence[str] = ()
    ) -> Margins:
        """Margins of the linear view at an operating point: gain, phase, delay, disk, Ms, Mt and their frequencies.

        The arguments are those of :meth:`linearize`.
        """
        return view("margins")(self, time, state, ideal)

    def step_response(
        self,
        duration: float | None = None,
        time: float | None = None,
        state: Mapping[str, float] | None = None,
        *,
        ideal: Sequence[str] = (),
    ) -> TimeResponseData:
        """The true output after a unit step of the command, by python-control: ``.time``, ``.outputs``, ``.plot()``.

        The other arguments are those of :meth:`linearize`. A nonlinear loop, its limits included, answers in
        :meth:`run` with ``references.step``.
        """
        return view("step_response")(self, duration, time, state, ideal)

    def manifest(self, engine: str) -> dict[str, Any]:
        """Everything needed to know what ran."""
        from importlib.metadata import version

        from leadscrew._version import __version__

        return {
            "schema_version": 1,
            "leadscrew": __version__,
            "name": self.name,
            "origin": self.origin,
            "engine": engine,
            "module": self.program.name,
            "seed": self.seed,
            "period_s": None if self.continuous else self.period,
            "sample_s": self.period if self.continuous else None,
            **self.integration,
            "computation_delay_s": self.sent * self.step,
            "transport_delay_s": self.seen * self.step,
            "bound": None if self.bound >= LARGEST else self.bound,
            "blocks": {s: b.name for s, b in self.blocks.items() if b is not None},
            "units": {s: b.unit for s, b in self.blocks.items() if b is not None and b.unit},
            "parameters": {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in self.parameters.items()},
            "platform": f"{platform.system()} {platform.machine()} Python {platform.python_version()}",
            "versions": {p: version(p) for p in ("numpy", "llvmlite", "scipy")},
            "created": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
        }


__all__ = ["RECORDED", "DivergenceWarning", "Loop", "RunWarning"]
