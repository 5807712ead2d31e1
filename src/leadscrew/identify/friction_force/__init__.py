"""Friction from a measured friction force: a tribometer's log, or any stage with a load cell against the friction.

Force against position and speed; the motion is an input, not something to be simulated, so no mass is needed.
:func:`read_force_record` or :func:`force_record` take the log, :func:`identify_friction_force` fits Coulomb and viscous
friction, the Stribeck map, Dahl, LuGre and Maxwell slip to its first part and judges each on the rest.
"""

from leadscrew.util.lazy_exports import exports

__getattr__, __dir__, __all__ = exports(__name__, __file__)
