"""Search and uncertainty: distributions over parameters, many runs anywhere, tuning, comparison, Monte Carlo.

Public here are ``tune``, ``Job`` and ``Space``. ``compare`` and ``montecarlo`` are modules of this package; their
functions are :func:`leadscrew.compare` and :func:`leadscrew.montecarlo`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from leadscrew.lazy import doors

if TYPE_CHECKING:
    from leadscrew.tune.job import Job
    from leadscrew.tune.space import Space
    from leadscrew.tune.tuner import tune

__all__ = ["Job", "Space", "tune"]

_HOMES = {
    "job": "Job",
    "space": "Space",
    "tuner": "tune",
}
"""The module of each public name."""


__getattr__, __dir__ = doors(globals(), _HOMES)
