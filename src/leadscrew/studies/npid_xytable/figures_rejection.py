"""Pictures of what lets a disturbance through: gain against frequency; and of the estimated speed of the spindle."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from leadscrew.controllers import cascade_ppi, input_dob, resonant
from leadscrew.controllers.inverse_feed_forward import inverse_feed_forward
from leadscrew.controllers.pid import TUNINGS as PID
from leadscrew.report.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION
from leadscrew.studies.npid_xytable.calibration import LINES_HZ, PERIOD_S
from leadscrew.studies.npid_xytable.rejection import BEST, let_through, opened
from leadscrew.studies.npid_xytable.scenarios import SPEEDS
from leadscrew.studies.npid_xytable.unknown_speed import DRIFT, NEAR, OFF, drifting, kept
from leadscrew.studies.study import Picture

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from leadscrew.kernel.block import Block
    from leadscrew.studies.npid_xytable.runs import Loops

SPINDLE_HZ = 50.0
"""Spindle of the resonators in the picture."""
BY_SPEED = dict(zip(SPEEDS, (BLUE, ORANGE, GREEN), strict=True))


class Curve(NamedTuple):
    """One line of the picture."""

    label: str
    block: Block
    colour: str
    line: str = "-"


def curves() -> list[Curve]:
    """What is compared, worst first."""
    full = resonant.resonant(PID["ours.pid_ms_159"], spindle_hz=SPINDLE_HZ)
    return [
        Curve("PID, Table I", PID["paper.pid"], VERMILION, "--"),
        Curve("Table I + observer, 60 rad/s", input_dob.TUNINGS["ours.pid_dob_60"], ORANGE),
        Curve("Table I + observer, 150 rad/s", input_dob.TUNINGS["ours.pid_dob_150"], ORANGE, "-."),
        Curve("best cascade, Ms 1.59", cascade_ppi.TUNINGS["ours.cascade"], GREEN),
        Curve("retuned PID, Ms 1.59", PID["ours.pid_ms_159"], SKY),
        Curve("best PID, Ms 1.60", BEST[1.6], BLUE),
        Curve("retuned PID + resonators", inverse_feed_forward(full), PURPLE),
    ]


def rejection_pictures(loops: Loops) -> list[Picture]:
    """Two pictures."""
    return [
        Picture(
            "disturbance_gain",
            "Error for 1 mV at the plant's input against frequency, in L*. Dotted: the lines of Table II, and of a "
            f"spindle at {60 * SPINDLE_HZ:,.0f} 1/min with two teeth, where the resonators have their zeros",
            disturbance_figure,
        ),
        Picture(
            "spindle_speed_found",
            "Estimated speed of the spindle, over the one that the controller was told: 2 % off, right, and drifting",
            lambda: speed_figure(loops),
        ),
    ]


def frequencies() -> np.ndarray:
    """A grid in Hz, denser at the resonators, none of them hit exactly."""
    wide = np.geomspace(0.3, 0.499 / PERIOD_S, 700)
    at = np.array([*resonant.ODD_HZ, SPINDLE_HZ, 2.0 * SPINDLE_HZ])
    away = np.geomspace(1e-4, 0.05, 16)
    return np.unique(np.concatenate([wide, np.outer(at, 1.0 + away).ravel(), np.outer(at, 1.0 - away).ravel()]))


def disturbance_figure() -> Figure:
    """Gain from the plant's input to the error."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.5, 5.2), layout="constrained")
    axes = figure.subplots()
    hz = frequencies()
    for label, block, shade, dash in curves():
        axes.loglog(hz, let_through(opened(block), hz), color=shade, linestyle=dash, linewidth=1.3, label=label)
    for line in (*LINES_HZ, SPINDLE_HZ, 2.0 * SPINDLE_HZ):
        axes.axvline(line, color=BLACK, linestyle=":", linewidth=0.8, alpha=0.6)
    axes.set(xlim=(hz[0], hz[-1]), ylim=(1e-4, 2.0), xlabel="frequency, Hz", ylabel="error per disturbance, um/mV")
    axes.grid(alpha=0.3)
    figure.legend(loc="outside lower center", ncols=3)
    return figure


def speed_figure(loops: Loops) -> Figure:
    """Estimated speed in time."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 4.2), layout="constrained")
    still, moving = figure.subplots(1, 2, sharey=True)
    for axes, found, title in (
        (still, kept(loops), f"constant speed, right and {100 * OFF:g} % off"),
        (moving, drifting(loops), f"speed grows by {100 * DRIFT:g} % a second"),
    ):
        for rpm, estimate in zip(found.rpm, found.estimate, strict=True):
            label = f"{rpm:,} 1/min" if f"{rpm:,} 1/min" not in axes.get_legend_handles_labels()[1] else None
            axes.plot(found.time, 100.0 * (estimate - 1.0), color=BY_SPEED[int(rpm)], linewidth=1.1, label=label)
        axes.set_title(title, fontsize=10)
        axes.set_xlabel("time, s")
        axes.grid(alpha=0.3)
    for share in (-OFF, 0.0, OFF):
        still.axhspan(*(100.0 * (share + s * NEAR) for s in (-1, 1)), color=BLACK, alpha=0.25, linewidth=0)
    grown = [100.0 * ((1.0 - OFF) * (1.0 + DRIFT * t) - 1.0) for t in (0.0, 20.0)]
    moving.plot([0.0, 20.0], grown, color=BLACK, linestyle=":", linewidth=1.0, label="true")
    still.set_ylabel("estimated over told speed, less 1, %")
    handles, labels = moving.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4)
    return figure
