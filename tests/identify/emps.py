"""The log of EMPS, and what was published of it; tests that use it skip where the data is not at hand."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from tests.fuzzy.formats_systems import shared
from tests.identify.axis_oracle import Axis

PUBLISHED = Axis(mass=95.109, viscous=203.50, coulomb=20.394, offset=-3.165)
"""A. Janot, M. Gautier, M. Brunot (2019), as the README of the data gives them."""


class Emps(NamedTuple):
    """s, N, m, m; the drive in V; gains of the cascade that was active."""

    time: np.ndarray
    force: np.ndarray
    position: np.ndarray
    command: np.ndarray
    drive: np.ndarray
    period: float
    gain: float
    kp: float
    kv: float


@lru_cache(maxsize=1)
def emps() -> Emps:
    from scipy.io import loadmat

    d = loadmat(shared("data/emps/DATA_EMPS.mat"))
    t, volts, position, command = (d[n].ravel().astype(float) for n in ("t", "vir", "qm", "qg"))
    gain = float(d["gtau"].item())
    return Emps(t, volts * gain, position, command, volts, float(t[-1] / (len(t) - 1)), gain, float(d["kp"].item()),
                float(d["kv"].item()))  # fmt: skip
