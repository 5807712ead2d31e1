"""The laboratory of a study: what its claims, experiments and figures measure, each computed once.

A *measure* is a function of the lab. Whoever asks for it first computes it; the others wait for the same result::

    @measure
    def largest_um(lab, controller): return 1000.0 * lab.run(controller, "step").metrics["max_error"]

    largest_um(lab, "ours.pd")
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable, Mapping
from concurrent.futures import Future
from functools import wraps
from typing import TYPE_CHECKING, Any, Concatenate, ParamSpec, TypeVar

from leadscrew.kernel.block import Block
from leadscrew.kernel.loop import RECORDED
from leadscrew.study_data import Assumption, Scenario, Study
from leadscrew.util.errors import entry_point

__all__ = ["Assumption", "Lab", "Scenario", "Study", "measure"]

if TYPE_CHECKING:
    from leadscrew.kernel.batch import Batch
    from leadscrew.kernel.loop import Loop
    from leadscrew.kernel.run import Run

P = ParamSpec("P")
T = TypeVar("T")


@entry_point
class Lab:
    """Loops and runs of a study, and every measure of it, computed when first asked for.

    Threads may ask at the same time. Raises, as its methods do, NameUnknown for a controller or scenario that the
    study does not have.
    """

    def __init__(self, study: Study) -> None:
        self.study = study
        self._kept: dict[Hashable, Future[Any]] = {}
        self._computing: dict[Hashable, int] = {}
        self._waiting: dict[int, Hashable] = {}
        self._lock = threading.Lock()
        self.runs: dict[str, Run] = {}
        """Runs of the study's own scenarios as they stand, by ``scenario/controller``: what a report saves."""

    def once(self, key: Hashable, compute: Callable[[], T]) -> T:
        """The value of a key, computed by the first who asks.

        Raises:
            RecursionError: to compute the value takes the value itself.
        """
        with self._lock:
            future, mine = self._kept.get(key), False
            if future is None:
                future, mine = Future(), True
                self._kept[key], self._computing[key] = future, threading.get_ident()
            elif not future.done():
                self._wait(key)
        if mine:
            try:
                future.set_result(compute())
            except BaseException as error:
                future.set_exception(error)
                raise
        try:
            value: T = future.result()
        finally:
            self._waiting.pop(threading.get_ident(), None)
        return value

    def _wait(self, key: Hashable) -> None:
        """Notes that this thread waits for a value; refuses where its computation waits for this thread."""
        me, wanted = threading.get_ident(), key
        while not self._kept[wanted].done():
            if (thread := self._computing[wanted]) == me:
                name = key[0] if isinstance(key, tuple) else key
                raise RecursionError(f"the measure {name} needs its own result")
            further = self._waiting.get(thread)
            if further is None:
                break
            wanted = further
        self._waiting[me] = key

    def loop(self, controller: str | Block, scenario: str | Scenario, **options: Any) -> Loop:
        """The study's loop; ``options`` go to its ``build``."""
        block = self.study.controller(controller) if isinstance(controller, str) else controller
        asked = self.study.scenario(scenario) if isinstance(scenario, str) else scenario
        loop = self.study.build(block, asked, **options)
        loop.adopt_program(self.once(("program", loop.compiled_from()), lambda: loop))
        return loop

    def run(self, controller: str, scenario: str, seconds: float | None = None, **options: Any) -> Run:
        """The run of a controller in a scenario, as long as the scenario unless ``seconds`` says otherwise.

        Recorded are command, feedback, output, true output and disturbance, and what ``study.record`` adds where the
        loop has it.
        """
        length = self.study.scenario(scenario).duration_s if seconds is None else seconds

        def simulate() -> Run:
            loop = self.loop(controller, scenario, **options)
            known = loop.program.plan.columns
            more = [name for name in self.study.record if any(c == name or c.startswith(f"{name}.") for c in known)]
            run = loop.run(length, record=(*RECORDED, *more))
            if not options:
                self.runs[f"{scenario}/{controller}"] = run
            return run

        return self.once(("run", controller, scenario, length, repr(sorted(options.items()))), simulate)

    def batch(
        self,
        controller: str | Block,
        scenario: str,
        varied: Mapping[str, Any],
        seconds: float | None = None,
        record: str | tuple[str, ...] | None = (),
        **options: Any,
    ) -> Batch:
        """Many runs with parameters varied by dotted key; not kept: a measure keeps what it makes of them."""
        length = self.study.scenario(scenario).duration_s if seconds is None else seconds
        return self.loop(controller, scenario, **options).batch(length, varied, record=record)


def measure(function: Callable[Concatenate[Lab, P], T]) -> Callable[Concatenate[Lab, P], T]:
    """Makes a function of the lab, and of arguments that can be hashed, a measure: computed once per lab."""

    @wraps(function)
    def once(lab: Lab, *args: P.args, **kwargs: P.kwargs) -> T:
        key = (f"{function.__module__}.{function.__qualname__}", args, tuple(sorted(kwargs.items())))
        return lab.once(key, lambda: function(lab, *args, **kwargs))

    return once
