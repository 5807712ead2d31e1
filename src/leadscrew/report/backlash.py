"""Pictures of backlash: classic play and dead band, and two masses that bounce in it."""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from leadscrew.kernel.block import controller, reference
from leadscrew.kernel.loop import Loop
from leadscrew.kernel.run import Run
from leadscrew.kernel.sheet import Unit
from leadscrew.plants._backlash import DeadBand, Play, followed, reaction
from leadscrew.plants._backlash_two_mass import backlash_two_mass
from leadscrew.report.friction import _below, _panels
from leadscrew.report.style import BLACK, BLUE, ORANGE, VERMILION

HEAVY = 1e12
"""A motor of this mass, kg, moves as it is told: the screw's place is imposed."""


class SineForceParams(NamedTuple):
    """The force that moves a mass by ``radius sin(rate t)``."""

    mass: Annotated[float, Unit("kg")] = HEAVY
    radius: Annotated[float, Unit("m")] = 1e-3
    rate: Annotated[float, Unit("rad/s")] = 2.0 * math.pi


@reference(SineForceParams())
def _sine_force(p, t):
    """Mass times acceleration."""
    return -p.mass * p.radius * p.rate * p.rate * math.sin(p.rate * t)


@controller()
def _through(command):
    """What is asked for."""
    return command


def imposed_loop(radius: float, rate: float, restitution: float, sample: float = 5e-5, **changes: float) -> Loop:
    """The loop of :func:`imposed_reversal`; ``changes`` are parameters of the plant."""
    two = backlash_two_mass(motor_mass=HEAVY, motor_viscous=0.0, restitution=restitution, **changes)
    guide, joint = two.params.guide, two.params.joint
    pressed = (guide.coulomb + guide.viscous * radius * rate) / joint.forward_stiffness
    plant = two.starting(
        motor_speed=radius * rate,
        table_speed=radius * rate,
        table=-joint.forward_gap - pressed,
        bristle=guide.coulomb / guide.stiffness,
    )
    return Loop(
        reference=_sine_force(radius=radius, rate=rate), controller=_through, plant=plant, period=None, sample=sample,
        rtol=1e-6, atol=1e-12, metrics={},
    )  # fmt: skip


def imposed_reversal(radius: float, rate: float, restitution: float, sample: float = 5e-5) -> Run:
    """Three quarters of a turn of ``radius sin(rate t)`` of the screw, in m and rad/s, and the table behind its play.

    Starts on the forward flank, pressed by the guide's friction; turns at ``t = pi / (2 rate)``.
    """
    loop = imposed_loop(radius, rate, restitution, sample)
    return loop.run(0.75 * 2.0 * math.pi / rate, record=("plant",)).check()


def classic_figure() -> Figure:
    """Classic backlash: the play's hysteresis and the dead band's reaction, with equal and with unlike sides."""
    figure, ((left, right),) = _panels(1, 2, 3.8)
    way = np.concatenate([np.linspace(0, 6, 200), np.linspace(6, -6, 400), np.linspace(-6, 6, 400)])
    equal = Play(1.0, 1.0)
    unlike = Play(0.5, 2.0, forward_slope=0.9, backward_slope=1.05)
    twist = np.linspace(-4, 4, 401)
    bands = (DeadBand(1.0, 1.0, 1e8, 1e8), DeadBand(0.5, 2.0, 5e7, 1.5e8))
    for p, band, colour, line, label in (
        (equal, bands[0], BLUE, "-", "equal sides, 1 um each"),
        (unlike, bands[1], ORANGE, "--", "unlike gaps (0.5 and 2 um) and slopes"),
    ):
        places, place = [], 0.0
        for x in way:
            place = followed(p, place, float(x))
            places.append(place)
        left.plot(way, places, color=colour, linestyle=line, linewidth=1.4, label=label)
        forces = [reaction(band, float(x)) * 1e-6 for x in twist]
        right.plot(twist, forces, color=colour, linestyle=line, linewidth=1.4, label=label)
    left.set(xlabel="drive (um)", ylabel="table (um)", title="play: the table follows one flank or stands")
    right.set(xlabel="twist, drive minus table (um)", ylabel="reaction (N)", title="dead band: force on the table")
    _below(figure, left, columns=2)
    return figure


def modern_figure() -> Figure:
    """Two masses: a reversal with an almost elastic and with a soft impact, against the classic play."""
    figure, ((left, right),) = _panels(1, 2, 3.8)
    radius, rate = 1e-3, 2.0 * math.pi
    for restitution, colour, line in ((0.9, BLUE, "-"), (0.05, VERMILION, "--")):
        run = imposed_reversal(radius, rate, restitution)
        since = 1e3 * (run.time - 0.25)
        near = (since > -5.0) & (since < 80.0)
        twist = 1e6 * (run["plant.motor"] - run["plant.table"])
        label = f"two masses, restitution {restitution:g}"
        left.plot(since[near], twist[near], color=colour, linestyle=line, linewidth=1.2, label=label)
        lag = 1e3 * run["plant.table_speed"]
        right.plot(since[near], lag[near], color=colour, linestyle=line, linewidth=1.2, label=label)
    screw = radius * np.sin(rate * run.time)
    table = -1e-6
    classic = []
    for x in screw:
        table = followed(Play(), table, float(x))
        classic.append(table)
    left.plot(since[near], 1e6 * (screw - classic)[near], color=BLACK, linestyle=":", label="classic play")
    speed = np.gradient(np.array(classic), run.time)
    right.plot(since[near], 1e3 * speed[near], color=BLACK, linestyle=":", label="classic play")
    left.set(xlabel="time after the reversal of the screw (ms)", ylabel="screw minus table (um)", title="2 um of play")
    right.set(xlabel="time after the reversal of the screw (ms)", ylabel="speed of the table (mm/s)",
              title="the table is hit, and bounces")  # fmt: skip
    _below(figure, left, columns=3)
    return figure
