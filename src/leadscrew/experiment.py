"""An experiment: one loop of a study, or of one's own file, with changes; and the file that describes it.

::

    schema_version = 2
    study = "vud_lathe"
    controller = "corrected.vud_beta_e"
    scenario = "fig11a_step_m50"
    duration = 4.0                      # seconds; the scenario's own unless given
    seed = 7                            # of all noise
    replicate = 4711                    # which stream of noise, as in a batch; 0 unless given

    [set]
    scenario.target_mm = -120
    plant.full_duty_speed_mm_s = 300

    [files]                             # SHA-256 of files that it needs; refused where one has changed
    "lathe.toml" = "9f2b..."
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from leadscrew import controller_file, legacy, names, resolve, toml_file
from leadscrew.kernel.parameters import ParameterSpec, entries, nearest, renamed
from leadscrew.util.errors import (
    BlockError,
    CodeNotTrusted,
    DataError,
    LeadscrewError,
    NameUnknown,
    ValueRefused,
    entry_point,
)
from leadscrew.util.frames import origin

if TYPE_CHECKING:
    from leadscrew.kernel.block import Block
    from leadscrew.kernel.loop import Loop
    from leadscrew.study_data import Study

SCHEMA_VERSION = legacy.CURRENT


@entry_point
@dataclass(frozen=True)
class Experiment:
    """One loop: of a study by controller and scenario, or from a file, with parameters changed by dotted key."""

    study: str
    """A study's name, a machine file (``.toml``), or ``path/file.py:name`` of a study, a loop, or a function that
    returns a loop."""
    controller: str | None = None
    """A controller of the study, a block of the catalogue, ``path/file.py:name``, a fuzzy system's file, or a
    controller file (``.toml``)."""
    scenario: str | None = None
    changes: Mapping[str, Any] = field(default_factory=dict)
    duration_s: float | None = None
    engine: str | None = None
    every: int = 1
    record: tuple[str, ...] | None = None
    seed: int | None = None
    replicate: int = 0
    """Which stream of noise: run ``k`` of a batch is the experiment with ``replicate=k``."""
    substeps: int | None = None
    """Integration steps of the plant a period; the study's unless given."""
    files: Mapping[str, str] = field(default_factory=dict)
    """SHA-256, by path, of controller and machine files that must be as they were; of others nothing is asked."""
    source: str = ""
    """The file that it was read from, for error texts."""

    def settable(self) -> dict[str, ParameterSpec]:
        """Everything that ``changes`` may name, by dotted key."""
        found = self._subject()
        if isinstance(found, _Loop()):
            return dict(found.sheet)
        controller, scenario = self._parts(found)
        sheet = {e.key: e for e in entries(found.scenario(scenario).params, "scenario.")}
        return sheet | found.loop(controller, scenario).sheet

    def loop(self) -> Loop:
        """The loop with the changes made; its ``origin`` says how to build it again.

        Raises:
            LeadscrewError: a name that does not exist or a value that is refused, with the file that it came from.
        """
        try:
            return self._loop()
        except LeadscrewError as error:
            if not self.source or isinstance(error, CodeNotTrusted):
                raise
            raise type(error)(f"{self.source}: {error}") from error

    def _loop(self) -> Loop:
        changes: Mapping[str, Any] = self.changes
        unknown = [k for k in changes if k not in (sheet := self.settable())]
        if unknown:
            changes = renamed(changes, sheet)
            unknown = [k for k in changes if k not in sheet]
        if unknown:
            raise NameUnknown(f"there is no parameter {unknown[0]!r}{nearest(unknown[0], list(sheet))}")
        self._check_files()
        found = self._subject()
        if isinstance(found, _Loop()):
            loop = found.using(changes)
        else:
            controller, scenario = self._parts(found)
            loop = found.loop(controller, scenario, changes)
            if self.controller is not None and names.is_fuzzy_file(self.controller):
                loop = _fitted(found, self.controller, scenario, changes, loop)
            loop = loop.using(name=f"{found.name} {self.controller} {scenario}")
        if self.seed is not None:
            loop = loop.using(seed=self.seed)
        if self.substeps is not None:
            loop = loop.using(substeps=self.substeps)
        loop.origin = self.origin
        return loop

    def _check_files(self) -> None:
        for path, now in resolve.digests(self.controller, self.study).items():
            if now and self.files.get(path, now) != now:
                raise ValueRefused(
                    f"{path} has changed since these numbers were computed: put the old file back, or remove its line "
                    "under [files] to run with the new one"
                )

    @property
    def origin(self) -> dict[str, Any]:
        """How to build the loop again; part of a run's manifest."""
        files = resolve.digests(self.controller, self.study)
        return {
            "study": names.absolute(self.study),
            "controller": None if self.controller is None else names.absolute(self.controller),
            "scenario": self.scenario,
            "changes": {k: v.tolist() if hasattr(v, "tolist") else v for k, v in self.changes.items()},
            **({} if self.substeps is None else {"substeps": self.substeps}),
            **({"files": files} if files else {}),
        }

    def seconds(self) -> float:
        """How long to run.

        Raises:
            ValueRefused: a loop of one's own, and no duration given.
        """
        if self.duration_s is not None:
            return self.duration_s
        found = self._subject()
        if isinstance(found, _Loop()):
            raise ValueRefused(f"{self.study} is a loop without a scenario: give its duration in seconds")
        return float(found.scenario(self._parts(found)[1]).duration_s)

    def with_first_scenario(self) -> Experiment:
        """The experiment with the study's first scenario, where none is given and a scenario is needed."""
        found = self._subject()
        if self.scenario is not None or isinstance(found, _Loop()):
            return self
        return replace(self, scenario=next(iter(found.scenarios)))

    def _subject(self) -> Any:
        """The study or the loop that the experiment is about."""
        from leadscrew.study_data import Study

        found = resolve.subject(self.study)
        if isinstance(found, Study):
            return found
        made = _made(found, self.study)
        if self.controller is not None or self.scenario is not None:
            raise ValueRefused(f"{self.study} is a loop, not a study: it takes no controller and no scenario")
        return made

    def _parts(self, study: Study) -> tuple[Block, str]:
        """Controller block and scenario name, both checked."""
        if self.scenario is None:
            raise ValueRefused(f"scenario is missing; {study.name} has {', '.join(study.scenarios)}")
        study.scenario(self.scenario)
        if self.controller is None:
            raise ValueRefused(f"controller is missing; {study.name} has {', '.join(study.controllers)}")
        return resolve.controller(study, self.controller), self.scenario


def _fitted(study: Study, name: str, scenario: str, changes: Mapping[str, Any], loop: Loop) -> Loop:
    """The loop of a fuzzy system's file; where the study's command or reading is a motion, of its position.

    Raises:
        BlockError: the study's own controllers take or give several numbers that are none.
    """
    try:
        _ = loop.signals
        return loop
    except BlockError:
        own = study.loop(next(iter(study.controllers)), scenario).signals
        several = [
            f"{what} is {', '.join(own[what]._fields)}"
            for what in ("command", "feedback", "output")
            if hasattr(own[what], "_fields")
        ]
        if not several:
            raise
        fields = _positions(own)
        if fields is None:
            raise BlockError(
                f"{name} does not fit {study.name}: a fuzzy system's file takes one command and one reading and gives "
                f"one output; here the {' and the '.join(several)}"
            ) from None
    block = replace(resolve.fuzzy_controller(name, *fields), **resolve.machine_of(study))
    return study.loop(block, scenario, changes)


def _positions(signals: Mapping[str, Any]) -> tuple[str, str] | None:
    """The fields of command and feedback whose difference is the error; None where that is not one position."""
    from leadscrew.kernel.frame import pairs, signal_tree

    compared = pairs(signal_tree(signals["command"]), signal_tree(signals["feedback"]))
    fields = compared[0].command, compared[0].other
    one = len(compared) == 1 and not hasattr(signals["output"], "_fields")
    return fields if one and all(f.rsplit(".", 1)[-1] in ("", "position") for f in fields) else None


def _Loop() -> type[Loop]:  # noqa: N802
    from leadscrew.kernel.loop import Loop

    return Loop


def _made(found: Any, name: str) -> Loop:
    from leadscrew.kernel.block import Block

    loop = found
    if callable(found) and not isinstance(found, Block | type):
        try:
            loop = found()
        except LeadscrewError:
            raise
        except Exception as error:
            at = origin(error)
            raise DataError(f"{name}() failed{at and f' at {at}'}: {type(error).__name__}: {error}") from error
    if not isinstance(loop, _Loop()):
        raise BlockError(
            f"{name} is of type {type(loop).__name__}; expected a study, a Loop, or a function that returns a Loop"
        )
    return loop


def is_file(name: str) -> bool:
    """Whether a name means an experiment file."""
    return name.endswith(".toml")


def read(path: str | Path) -> Experiment:
    """An experiment from its TOML file; files that it names are looked for beside it.

    Nothing runs here. Python that it names runs by the rule of :mod:`leadscrew.userfile`, when the loop is built.

    A controller file gives its study with this controller, a machine file the machine.

    Raises:
        DataError: no such file, bad TOML, an unknown key or a value of the wrong type; names file and key.
    """
    from leadscrew.experiment_file import validated

    where = Path(path)
    table = toml_file.read(where)
    if table.get("kind") == "machine":
        return Experiment(names.absolute(str(where)), source=str(where))
    if table.get("kind") == controller_file.KIND:
        subject = controller_file.validated(table, where).study
        return Experiment(subject, names.absolute(str(where)), source=str(where))
    found = Experiment(**validated(table, str(where)))
    return replace(
        found,
        study=names.from_file(found.study, where),
        controller=None if found.controller is None else names.from_file(found.controller, where),
        files={names.from_file(k, where): v for k, v in found.files.items()},
    )
