"""The loops of a study and the runs that claims and pictures need; each run is made once."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any

from leadscrew.kernel.block import Block
from leadscrew.studies.study import Scenario

if TYPE_CHECKING:
    from leadscrew.kernel.live import Live
    from leadscrew.kernel.loop import Loop


class StudyLoops:
    """Loops of a study. Runs are kept.

    Args:
        controllers, scenarios: of the study, by name.
        build: ``(controller, scenario, **options) -> Loop``.
        signals: what a run records unless told otherwise.
    """

    def __init__(
        self,
        controllers: Mapping[str, Block],
        scenarios: Mapping[str, Scenario],
        build: Callable[..., Loop],
        signals: tuple[str, ...],
    ) -> None:
        self.controllers, self.scenarios, self.build, self.signals = controllers, scenarios, build, signals
        self._runs: dict[Any, Any] = {}

    def get(self, controller: str | Block, scenario: str | Scenario, **options: Any) -> Loop:
        """The loop that ``build`` makes for these names."""
        block = self.controllers[controller] if isinstance(controller, str) else controller
        return self.build(block, self.asked(scenario), **options)

    def run(
        self,
        controller: str | Block,
        scenario: str | Scenario,
        seconds: float | None = None,
        record: tuple[str, ...] | None = None,
        every: int = 1,
        **options: Any,
    ) -> Any:
        """A run of the loop, made once for the same arguments; as long as the scenario unless told otherwise."""
        wanted = self.signals if record is None else record
        key = self._key(controller, scenario, seconds, wanted, every, options)
        if isinstance(controller, str) and key in self._runs:
            return self._runs[key]
        loop, asked = self.get(controller, scenario, **options), self.asked(scenario)
        done = loop.run(asked.duration_s if seconds is None else seconds, record=wanted, every=every)
        if isinstance(controller, str):
            self._runs[key] = done
        return done

    def ahead(self, wanted: Iterable[tuple[str, str, Mapping[str, Any]]]) -> None:
        """Makes runs of :meth:`run` side by side, one a core, for what will be asked: controller, scenario, options."""
        from leadscrew.kernel.loop import DivergenceWarning

        lives: dict[Any, tuple[Live, float]] = {}
        for controller, scenario, options in wanted:
            key = self._key(controller, scenario, None, self.signals, 1, options)
            if key not in self._runs and key not in lives:
                live = self.get(controller, scenario, **options).start()
                lives[key] = live, self.asked(scenario).duration_s
        with ThreadPoolExecutor(os.cpu_count()) as side_by_side, warnings.catch_warnings():
            warnings.simplefilter("ignore", DivergenceWarning)
            done = side_by_side.map(self._advance, lives.values())
            self._runs.update(zip(lives, done, strict=True))

    def _advance(self, begun: tuple[Live, float]) -> Any:
        live, seconds = begun
        return live.advance(live.loop.periods(seconds), record=self.signals)

    def asked(self, scenario: str | Scenario) -> Scenario:
        """The scenario itself, for its name."""
        return self.scenarios[scenario] if isinstance(scenario, str) else scenario

    def _key(self, controller: Any, scenario: str | Scenario, *rest: Any) -> Any:
        asked = self.asked(scenario)
        return (controller, asked.name, asked.params, *rest[:-1], repr(sorted(rest[-1].items())))

    @property
    def runs(self) -> dict[str, Any]:
        """The kept runs of plain scenarios, by ``scenario/controller``."""
        return {f"{key[1]}/{key[0]}": run for key, run in self._runs.items() if key[-1] == "[]"}
