"""What a command is about: a study by name, from a file, from a plug-in, or from an experiment file."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from leadscrew.experiment import Experiment
    from leadscrew.study_data import Study

INTERVALS = "intervals"
"""``--over intervals``: all that the log of a machine file leaves open."""


def experiment_of(name: str) -> Experiment:
    """The experiment of a file, or an empty one about the study or loop of that name."""
    from leadscrew import experiment

    return experiment.read(name) if experiment.is_file(name) else experiment.Experiment(name)


def study_of(name: str) -> Study:
    """The study of a name or of an experiment file.

    Raises:
        LeadscrewError: there is none.
    """
    from leadscrew import resolve

    return resolve.study(experiment_of(name).study)


def whole_study(name: str) -> tuple[str, Study]:
    """Its name and the study, for a command that judges all of it.

    Raises:
        ValueRefused: an experiment file that asks for one loop.
    """
    from leadscrew import names, resolve
    from leadscrew.util.errors import ValueRefused

    found = experiment_of(name)
    if found.controller or found.scenario or found.changes:
        raise ValueRefused(f"{name} describes one loop: use leadscrew simulate {name}; run judges a whole study")
    return names.absolute(found.study), resolve.study(found.study)


def spread(name: str, over: Sequence[str] | None) -> list[str]:
    """What differs from plant to plant; ``intervals`` stands for all that a machine file's log leaves open.

    Raises:
        ValueRefused: intervals of something that is no machine file.
    """
    from leadscrew.util.errors import ValueRefused

    found: list[str] = []
    for text in over or ():
        if text != INTERVALS:
            found.append(text)
            continue
        where = experiment_of(name).study
        if not where.endswith(".toml"):
            raise ValueRefused(f"--over {INTERVALS}: {name} is no machine file; name the keys, as KEY=LOW:HIGH")
        from leadscrew.machine.axis_study import left_open

        found += left_open(where)
    return found
