"""First gains for an identified axis: by its mass, delay, encoder and noise; a start for ``leadscrew tune``.

Speed loop around ``f / (M s)`` with the delay ``tau = delay + dt + filter`` (half a period each of the hold and of the
difference that the speed is taken from, and the lag of the speed):

    w_v = 0.4 / tau          the delay costs 23 degrees at the crossover of the speed loop
    kvp = w_v M / f,   kvi = kvp w_v / 8,   kpos = w_v / 4
    kvp q / (dt + filter) <= share u_max     what a count, or noise, of q moves the drive by: the filter sees to it

With the corner of the integral an eighth and the position loop a quarter of ``w_v`` the speed loop keeps a phase margin
of about 60 degrees (G. Ellis, *Control System Design Guide*, 4th ed., 2012, chapters 6 and 16: zones by fixed ratios).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from leadscrew.machine.file import MachineFile
from leadscrew.util.errors import DataError

LATE = 0.4
"""Crossover times delay."""
JITTER = 0.05
"""Share of the drive's range that one count, or noise, may move it by."""
SIZES = 3.0 * math.sqrt(2.0)
"""Of the noise's standard deviation: what two readings rarely differ by."""
PEAK = 1.5
"""Of sensitivity and complementary sensitivity: a phase margin of 39 degrees and a gain margin of 3 at least."""
LEADS = (0.0, math.radians(30.0), math.radians(60.0))
"""Of the derivative at the crossover."""
SHARES = (1.0 / 15.0, 1.0 / 6.0, 1.0 / 3.0, 1.0, 3.0)
"""Integral over proportional term at the crossover."""
HIGHEST = 0.2
"""Share of half of the sampling rate up to which a crossover is tried."""
ALIASES = 3
"""Multiples of the sampling rate beyond which the plant hardly answers."""
CROSSOVERS, POINTS = 60, 400
"""Crossovers that are tried, and frequencies at which each is judged."""
PER_SI = {"m": 1.0, "mm": 1e3, "um": 1e6, "rad": 1.0, "deg": math.degrees(1.0), "mrad": 1e3}
"""Units that a machine file may show its position in, per m or rad."""


class CascadeGains(NamedTuple):
    """Gains of :obj:`leadscrew.controllers.axis_cascade`, and the lag of its speed."""

    kpos: float
    kvp: float
    kvi: float
    filter_s: float


def per_si(machine: MachineFile) -> float:
    """Units shown per m or rad.

    Raises:
        DataError: an unknown unit.
    """
    if machine.position_unit not in PER_SI:
        raise DataError(
            f"{machine.name}: position_unit = {machine.position_unit!r}: expected one of {', '.join(PER_SI)}"
        )
    return PER_SI[machine.position_unit]


def cascade(machine: MachineFile) -> CascadeGains:
    """Gains for the mass, delay, encoder and noise of a machine; in its units."""
    inertia = float(machine.parameters["mass"]) / (float(machine.parameters["force_per_drive"]) * per_si(machine))
    shaken = LATE * inertia * max(machine.resolution, SIZES * machine.noise) / (JITTER * machine.drive)
    # (delay + x) x = shaken with x = dt + filter
    needed = 0.5 * (math.sqrt(machine.delay_s**2 + 4.0 * shaken) - machine.delay_s)
    span = max(machine.period, needed)
    rate = LATE / (machine.delay_s + span)
    return CascadeGains(0.25 * rate, rate * inertia, rate * rate * inertia / 8.0, span - machine.period)


class Pid(NamedTuple):
    """Gains of :obj:`leadscrew.controllers.pid`, and the lag of its derivative."""

    kp: float
    ki: float
    kd: float
    filter_s: float


def pid(machine: MachineFile) -> Pid:
    """Gains for a linear machine: the largest integral gain of which the loop stands well away from instability.

    At every crossover ``w`` of a grid, with leads of 0, 30 and 60 degrees (``kd w = kp tan(lead)``) and integrals of
    ``ki = kp w / 15`` to ``3 kp w``, the loop with its delays is judged by its frequency response. Taken is the
    largest ``ki`` with ``|S|`` and ``|T|`` of at most 1.5 at all frequencies (K. J. Astrom, H. Panagopoulos,
    T. Hagglund, Design of PI controllers based on non-convex optimization, *Automatica* 34, 1998, 585), a stable loop
    (Nyquist), and one count of the encoder, or three standard deviations of its noise, moving the drive by no more than
    a twentieth of its range. Where no gains meet all of this the stable ones with the least peak are taken.

    Raises:
        DataError: a plant of negative gain, or one that none of these gains holds.
    """
    denominator = np.asarray(machine.parameters["denominator"], dtype=float)
    w, plant = _plant(machine)
    z = np.exp(1j * w * machine.period)
    integrators = len(denominator) - 1 - int(np.flatnonzero(denominator)[-1])
    unstable = int(np.sum(np.roots(denominator).real > 1e-9 * np.abs(denominator[1:]).max(initial=1.0)))
    turns = 0.5 * math.pi * (integrators + 1) + math.pi * unstable
    best: tuple[tuple[bool, float], Pid] | None = None
    for at in np.geomspace(w[0], HIGHEST * math.pi / machine.period, CROSSOVERS).tolist():
        for lead in LEADS:
            for share in SHARES:
                unit = Pid(1.0, at * share, math.tan(lead) / at, 0.1 / at)
                open_loop = _answer(unit, z, machine.period) * plant
                kp = 1.0 / float(np.interp(at, w, np.abs(open_loop)))
                peak = _peak(kp * open_loop, turns)
                if not math.isfinite(peak):
                    continue
                gains = Pid(kp, kp * unit.ki, kp * unit.kd, unit.filter_s)
                good = peak <= PEAK and _jitter(gains, machine) <= JITTER * machine.drive
                score = (good, gains.ki if good else -peak)
                best = max(best, (score, gains), key=lambda pair: pair[0]) if best else (score, gains)
    if best is None:
        raise DataError(f"{machine.name}: no PID of positive gains holds this plant: {_why(machine)}")
    return best[1]


def _plant(machine: MachineFile) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies, rad/s, dense at resonances, and the response there with delay and hold."""
    numerator, denominator = (np.asarray(machine.parameters[k], dtype=float) for k in ("numerator", "denominator"))
    roots = np.concatenate([np.roots(numerator), np.roots(denominator)])
    top = math.pi / machine.period
    slow = min([float(abs(r)) for r in roots if 0.0 < abs(r) < top], default=top)
    around = [abs(r) + max(abs(r.real), 1e-6 * abs(r)) * np.linspace(-10.0, 10.0, 61) for r in roots if r.imag > 0.0]
    grid = np.concatenate([np.geomspace(1e-3 * min(slow, 1e-2 * top), top, POINTS), *around])
    w = np.unique(grid[(grid > 0.0) & (grid <= top)])
    # The response from sample to sample is the sum over all frequencies that look alike to the sampler.
    alike = w[:, None] + 2.0 * top * np.arange(-ALIASES, ALIASES + 1.0)
    half = 0.5 * alike * machine.period
    hold = np.sinc(half / math.pi) * np.exp(-1j * (half + alike * machine.delay_s))
    return w, np.sum(np.polyval(numerator, 1j * alike) / np.polyval(denominator, 1j * alike) * hold, axis=1)


def _answer(g: Pid, z: np.ndarray, period: float) -> np.ndarray:
    """Of :mod:`leadscrew.controllers._parallel`, from sample to sample."""
    back = 1.0 - 1.0 / z
    return np.asarray(g.kp + g.ki * period / back + g.kd * back / (g.filter_s * back + period))


def _peak(open_loop: np.ndarray, turns: float) -> float:
    """Largest of ``|S|`` and ``|T|``; infinite where the loop is unstable: ``1 + L`` does not turn as it must."""
    there = 1.0 + open_loop
    turned = float(np.sum(np.angle(there[1:] / there[:-1])))
    if abs(turned - turns) > 0.4 * math.pi:
        return math.inf
    return float(max((1.0 / np.abs(there)).max(), np.abs(open_loop / there).max()))


def _jitter(g: Pid, machine: MachineFile) -> float:
    """How far one count, or noise, moves the drive."""
    return max(machine.resolution, 3.0 * machine.noise) * (g.kp + g.kd / (g.filter_s + machine.period))


def _why(machine: MachineFile) -> str:
    if np.any(np.roots(machine.parameters["denominator"]).real > 0.0):
        return "it has a pole in the right half plane, and its delay is too long for it, or its gain negative"
    return "its gain is negative; turn the numerator's signs, and the drive at the machine"
