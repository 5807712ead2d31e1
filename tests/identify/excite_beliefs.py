"""What the tests of ``leadscrew excite`` believe of an axis, and how far it may go."""

from leadscrew.identify.excite import Limits
from leadscrew.identify.excite.belief import Belief, keys_of, values_of

LIMITS = Limits(0.0, 0.3, 0.2, 2.0, 20.0, 90.0)
VALUES = {"mass": 95.0, "coulomb": 20.0, "viscous": 200.0, "offset": -3.0, "static": 28.0, "stribeck_speed": 0.005,
          "stiffness": 1e6, "damping": 1e3, "backlash": 2e-5}  # fmt: skip


def believed(*tell, noise=1e-6, symmetric=True, force_noise=0.0, **more):
    return Belief(values_of({**VALUES, **more}), noise, 1e-3, symmetric, force_noise, wanted=keys_of(tell))
