"""The DC torque motor of the lathe in Long et al. (2014), J255LYX02: what the paper prints of it, and what follows.

Section II gives two sets of data at locked rotor, peak and continuous. At locked rotor there is no back-EMF, so that
voltage over current is the armature's resistance, ``R = U / I``, and torque over current the torque constant,
``K_t = M / I``; in SI units the constant of the back-EMF is the same number, ``K_e = K_t`` in V s/rad.

The equations (2) and (3) are taken as printed: 30 V at full duty, and 0.26 rad/s a volt. With the two lags of (3),
``T_e`` and ``T_m``, as the poles of armature and rotor together (see :obj:`leadscrew.plants.lathe_servo_limited`):

    L = R T_e T_m / (T_e + T_m),    J = (T_e + T_m) K_t K_e / R
"""

from __future__ import annotations

from typing import NamedTuple

LATHE_MOTOR = "J255LYX02"


class Datum(NamedTuple):
    """One number, its unit and where it is from."""

    value: float
    unit: str
    source: str


class LockedRotor(NamedTuple):
    """Voltage, current and torque of a motor that is held."""

    voltage: Datum
    current: Datum
    torque: Datum

    @property
    def resistance_ohm(self) -> float:
        """``U / I``."""
        return self.voltage.value / self.current.value

    @property
    def torque_constant(self) -> float:
        """``M / I`` in N m/A."""
        return self.torque.value / self.current.value

    @property
    def heat_w(self) -> float:
        """``U I``: all of it is heat while the rotor is held."""
        return self.voltage.value * self.current.value


MOTOR_PEAK = LockedRotor(
    Datum(48.0, "V", "section II: peak voltage at locked rotor"),
    Datum(7.5, "A", "section II: peak current at locked rotor"),
    Datum(23.0, "N m", "section II: peak torque at locked rotor"),
)
MOTOR_CONTINUOUS = LockedRotor(
    Datum(24.0, "V", "section II: continuous voltage at locked rotor"),
    Datum(3.75, "A", "section II: continuous current at locked rotor"),
    Datum(11.5, "N m", "section II: continuous torque at locked rotor"),
)
SUPPLY = Datum(30.0, "V", "dc gain of (2), taken as volt at full duty")
SPEED_GAIN = Datum(
    0.26, "rad/(s V)", "dc gain of (3); the paper prints no unit, this one fits the torque constant best"
)
PWM_LAG = Datum(0.0008, "s", "(2)")
ELECTRICAL_LAG = Datum(0.0015, "s", "(3), the shorter lag")
MECHANICAL_LAG = Datum(0.017, "s", "(3), the longer lag")
TOP_SPEED = Datum(258.7, "mm/s", "(6) and Table 1: 25.87 mm in 0.1 s is the full scale of ec")


class Derived(NamedTuple):
    """What follows from the data by the formulas above."""

    resistance_ohm: float
    torque_constant: float
    """N m/A, which is V s/rad."""
    speed_constant: float
    """``1 / K_e``: rad/s a volt of a motor without load."""
    stall_current_a: float
    """At the supply of (2), rotor held."""
    stall_torque_nm: float
    held_duty: float
    """Duty at which a held rotor draws the continuous current."""
    top_turning_speed: float
    """Product of the gains of (2) and (3), rad/s."""
    inductance_h: float
    inertia_kg_m2: float
    """Rotor, screw and slide together, if the friction is small."""


def motor_constants() -> Derived:
    """All of them, from the peak data (the continuous ones give the same resistance and torque constant)."""
    ohm, constant = MOTOR_PEAK.resistance_ohm, MOTOR_PEAK.torque_constant
    stall = SUPPLY.value / ohm
    both = ELECTRICAL_LAG.value + MECHANICAL_LAG.value
    return Derived(
        resistance_ohm=ohm,
        torque_constant=constant,
        speed_constant=1.0 / constant,
        stall_current_a=stall,
        stall_torque_nm=stall * constant,
        held_duty=MOTOR_CONTINUOUS.current.value / stall,
        top_turning_speed=SUPPLY.value * SPEED_GAIN.value,
        inductance_h=ohm * ELECTRICAL_LAG.value * MECHANICAL_LAG.value / both,
        inertia_kg_m2=both * constant * constant / ohm,
    )
