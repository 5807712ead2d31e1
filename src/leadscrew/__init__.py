"""Leadscrew: intelligent control of machine-tool axes and cutting processes.

Everything public is here. Names load what they need when they are first used, so that ``import leadscrew`` itself
stays light.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from leadscrew.kernel import views
from leadscrew.lazy import doors

__version__ = "0.1.0"

if TYPE_CHECKING:
    from leadscrew.catalogue import block, study
    from leadscrew.controllers.series import series
    from leadscrew.experiment import Experiment
    from leadscrew.figures.runs import plot_runs
    from leadscrew.kernel.batch import Batch
    from leadscrew.kernel.block import Block, actuator, controller, disturbance, metric, plant, reference, sensor
    from leadscrew.kernel.errors import (
        BlockError,
        CodeNotTrusted,
        DataError,
        Diverged,
        LeadscrewError,
        NameUnknown,
        SubsetError,
        ValueRefused,
    )
    from leadscrew.kernel.live import Live
    from leadscrew.kernel.loop import DivergenceWarning, Loop
    from leadscrew.kernel.noise import normal, uniform
    from leadscrew.kernel.run import Run, load
    from leadscrew.kernel.sheet import Doc, Ge, Gt, Le, Lt, Unit
    from leadscrew.tune.compare import compare
    from leadscrew.tune.job import Job
    from leadscrew.tune.montecarlo import montecarlo
    from leadscrew.tune.space import Space
    from leadscrew.userfile import trust

__all__ = [
    "Batch",
    "Block",
    "BlockError",
    "CodeNotTrusted",
    "DataError",
    "Diverged",
    "DivergenceWarning",
    "Doc",
    "Experiment",
    "Ge",
    "Gt",
    "Job",
    "Le",
    "LeadscrewError",
    "Live",
    "Loop",
    "Lt",
    "NameUnknown",
    "Run",
    "Space",
    "SubsetError",
    "Unit",
    "ValueRefused",
    "actuator",
    "block",
    "compare",
    "controller",
    "disturbance",
    "load",
    "metric",
    "montecarlo",
    "normal",
    "plant",
    "plot_runs",
    "reference",
    "sensor",
    "series",
    "study",
    "trust",
    "uniform",
]

_HOMES = {
    "catalogue": "block study",
    "controllers.series": "series",
    "experiment": "Experiment",
    "figures.runs": "plot_runs",
    "kernel.batch": "Batch",
    "kernel.block": "Block actuator controller disturbance metric plant reference sensor",
    "kernel.errors": "BlockError CodeNotTrusted DataError Diverged LeadscrewError NameUnknown SubsetError ValueRefused",
    "kernel.live": "Live",
    "kernel.loop": "DivergenceWarning Loop",
    "kernel.noise": "normal uniform",
    "kernel.run": "Run load",
    "kernel.sheet": "Doc Ge Gt Le Lt Unit",
    "tune.compare": "compare",
    "tune.job": "Job",
    "tune.montecarlo": "montecarlo",
    "tune.space": "Space",
    "userfile": "trust",
}
"""The module of each public name. The function ``tune`` is in the package that has its name here."""


views.HOMES.update(
    run_figure="leadscrew.figures.runs:run_figure",
    linearize="leadscrew.analysis.linearization:linearize",
    margins="leadscrew.analysis.linearization:margins",
    step_response="leadscrew.analysis.linearization:step_response",
)

__getattr__, __dir__ = doors(globals(), _HOMES)
