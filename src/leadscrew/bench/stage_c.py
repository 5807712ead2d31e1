"""The stage's loop hand-written in C: five ways to step it, compiled into the cache."""

from __future__ import annotations

import ctypes
import math

import numpy as np

from leadscrew.bench.stage_schemes import PERIOD_S, SINES, SoftParams
from leadscrew.bench.yardstick import build
from leadscrew.friction.lugre import LuGre, steady_bristle
from leadscrew.plants._ballscrew_stage import INERTIA, TRAVEL_MM_PER_RAD

FIELDS = (
    "amplitude", "rate", "period", "substeps", "lam", "gain", "smooth", "ahead_coulomb", "ahead_viscous", "inertia",
    "stiffness", "damping", "viscous", "coulomb", "rise", "per_speed",
)  # fmt: skip
FORMS = {
    "euler": "explicit Euler",
    "rk4": "RK4",
    "split": "split, bristles exact at a frozen speed",
    "implicit": "backward Euler, Newton on the speed",
    "exponential": "exponential Rosenbrock-Euler",
}
"""The functions of ``stage.c`` and what they are."""


class Stage(ctypes.Structure):
    """Mirrors ``Stage`` of ``stage.c``."""

    _fields_ = tuple((name, ctypes.c_double) for name in FIELDS)


class State(ctypes.Structure):
    """Mirrors ``State`` of ``stage.c``."""

    _fields_ = tuple((name, ctypes.c_double) for name in ("angle", "speed", "bristle"))


class ByHand:
    """The C loops of one command."""

    def __init__(self, sine: str) -> None:
        self.library = build("stage.c")
        self.sine = sine
        pointer = ctypes.POINTER(ctypes.c_double)
        for name in FORMS:
            entry = getattr(self.library, f"stage_{name}")
            entry.argtypes, entry.restype = [ctypes.POINTER(Stage), ctypes.POINTER(State), pointer, ctypes.c_long], None

    def run(self, form: str, microseconds: float, holds: int) -> np.ndarray:
        """The angle at the start of each hold, rad."""
        amplitude, rate, _ = SINES[self.sine]
        amplitude /= TRAVEL_MM_PER_RAD
        f, c = LuGre(), SoftParams()
        stage = Stage(
            amplitude, rate, PERIOD_S, round(1e6 * PERIOD_S / microseconds), c.lam, c.gain, c.smooth, c.hat.coulomb,
            c.hat.viscous, INERTIA, f.stiffness, f.damping, f.viscous, f.coulomb, f.static - f.coulomb,
            1.0 / f.stribeck_speed,
        )  # fmt: skip
        assert math.isclose(c.hat.static, c.hat.coulomb), "the C has no Stribeck term in its feed-forward"
        state = State(0.0, amplitude * rate, steady_bristle(f, amplitude * rate))
        angles = np.empty(holds)
        getattr(self.library, f"stage_{form}")(
            stage, state, angles.ctypes.data_as(ctypes.POINTER(ctypes.c_double)), holds
        )
        return angles
