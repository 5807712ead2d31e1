"""Ball-screw axis of the XY table with the first mode of its screw: equation (1) on two masses.

    (1 - s) x_m'' = gain u - damping x_m' - stiffness x_m - k (x_m - x_t) - c (x_m' - x_t')        motor side, mm
    s x_t'' = gain load + k (x_m - x_t) + c (x_m' - x_t')        table
    k = s (1 - s) (2 pi mode_hz)^2,      c = 2 mode_damping s (1 - s) 2 pi mode_hz

``s`` is the part of the moved mass that is the table's, ``mode_hz`` the frequency of the two against each other,
``mode_damping`` its damping ratio, both of the free mode. Seen from the motor the mode follows a zero at
``mode_hz sqrt(1 - s)`` and the phase never falls below that of one mass (collocated); seen from the table there is no
zero, and the mode turns the phase by -180 degrees (``at_table``, the default: a linear scale).

As ``mode_hz`` grows it becomes equation (1) of Abdullah et al. (see :obj:`leadscrew.plants.xy_table`), whatever ``s``.
The paper's plant is rigid; first modes of ball-screw axes lie at about 40 to 150 Hz. Half of the mass and 3 % of
damping are chosen. A disturbance acts on the table, in volt; damping and stiffness of (1) act on the motor's side,
where back-EMF and bearings are.

Stepped by its exact zero-order hold. Dead time: ``Loop(substeps=20, computation_delay=0.775e-3)``.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Annotated, NamedTuple

import numpy as np

from leadscrew.kernel.block import plant
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit
from leadscrew.plants._linear import hold_matrices


class XYTableTwoMassParams(NamedTuple):
    """Equation (1), and the mode."""

    gain: Annotated[float, Unit("mm/(V s^2)"), Gt(0), Doc("numerator: acceleration at 1 V from rest, (1)")] = 69380.0
    damping: Annotated[float, Unit("1/s"), Ge(0), Doc("denominator, coefficient of s, (1)")] = 144.8
    stiffness: Annotated[float, Unit("1/s^2"), Ge(0), Doc("denominator, constant coefficient, (1)")] = 166.3
    mode_hz: Annotated[float, Unit("Hz"), Gt(0), Le(1e5), Doc("frequency of the free mode; chosen")] = 100.0
    mode_damping: Annotated[float, Ge(0), Le(10), Doc("damping ratio of the free mode; chosen")] = 0.03
    table_share: Annotated[float, Ge(0.01), Le(0.99), Doc("part of the mass that is the table's; chosen")] = 0.5
    at_table: Annotated[bool, Doc("show the table, by a scale; otherwise the motor, by an encoder")] = True


class XYTableTwoMassState(NamedTuple):
    """Motor side and table."""

    motor: Annotated[float, Unit("mm"), Doc("position of the motor side, as travel")] = 0.0
    motor_velocity: Annotated[float, Unit("mm/s")] = 0.0
    table: Annotated[float, Unit("mm")] = 0.0
    table_velocity: Annotated[float, Unit("mm/s")] = 0.0


class Column(NamedTuple):
    """What one number adds to the state over one step."""

    motor: float
    motor_velocity: float
    table: float
    table_velocity: float


class XYTableTwoMassHold(NamedTuple):
    """The exact step over one integration step."""

    motor: Column
    motor_velocity: Column
    table: Column
    table_velocity: Column
    drive: Column
    load: Column
    at_table: bool


def matrices(params: XYTableTwoMassParams) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """``A``, the columns of voltage and load, and the row of what is shown."""
    s, w = params.table_share, 2.0 * math.pi * params.mode_hz
    k, c = s * (1.0 - s) * w * w, 2.0 * params.mode_damping * s * (1.0 - s) * w
    m = 1.0 - s
    a = np.array([
        [0.0, 1.0, 0.0, 0.0],
        [-(params.stiffness + k) / m, -(params.damping + c) / m, k / m, c / m],
        [0.0, 0.0, 0.0, 1.0],
        [k / s, c / s, -k / s, -c / s],
    ])  # fmt: skip
    shown = np.array([0.0, 0.0, 1.0, 0.0] if params.at_table else [1.0, 0.0, 0.0, 0.0])
    return a, np.array([0.0, params.gain / m, 0.0, 0.0]), np.array([0.0, 0.0, 0.0, params.gain / s]), shown


@lru_cache(maxsize=1024)
def hold(params: XYTableTwoMassParams, dt: float) -> XYTableTwoMassHold:
    """The exact step."""
    a, drive, load, _ = matrices(params)
    transition, driven = hold_matrices(a, drive, dt)
    _, loaded = hold_matrices(a, load, dt)
    x, v, y, w = (Column(*map(float, column)) for column in transition.T)
    return XYTableTwoMassHold(x, v, y, w, Column(*map(float, driven)), Column(*map(float, loaded)), params.at_table)


def shown(p, s):
    """Position of the table, or of the motor side."""
    return s.table if p.at_table else s.motor


@plant(XYTableTwoMassParams, XYTableTwoMassState, output=shown, prepare=hold, unit="mm", drive="voltage")
def xy_table_two_mass(p, s, u, load, dt):
    """Ball-screw axis of the XY table, equation (1) on two masses with one mode: state one step later."""
    a, b, c, d = p.motor, p.motor_velocity, p.table, p.table_velocity
    x, v, y, w = s.motor, s.motor_velocity, s.table, s.table_velocity
    return XYTableTwoMassState(
        a.motor * x + b.motor * v + c.motor * y + d.motor * w + p.drive.motor * u + p.load.motor * load,
        a.motor_velocity * x + b.motor_velocity * v + c.motor_velocity * y + d.motor_velocity * w
        + p.drive.motor_velocity * u + p.load.motor_velocity * load,
        a.table * x + b.table * v + c.table * y + d.table * w + p.drive.table * u + p.load.table * load,
        a.table_velocity * x + b.table_velocity * v + c.table_velocity * y + d.table_velocity * w
        + p.drive.table_velocity * u + p.load.table_velocity * load,
    )  # fmt: skip
