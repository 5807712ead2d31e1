"""The two by two of sensor and controller as a picture."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np
from matplotlib.figure import Figure

from leadscrew.report.style import colour
from leadscrew.studies.study import Picture
from leadscrew.studies.vud_lathe.accuracy import spread
from leadscrew.studies.vud_lathe.runs import STEPS

ROWS = (("ours.original_fit", "old controller"), ("corrected.vud_beta_e", "corrected VUD"))
COLUMNS = (("encoder", "encoder on the screw"), ("grating", "grating on the table"))
LINES = {STEPS[0]: ("-", "-50 mm"), STEPS[1]: ("--", "-170 mm")}


def accuracy_pictures(errors: Mapping[tuple[str, str, str], np.ndarray]) -> list[Picture]:
    """The picture of the errors that :func:`leadscrew.studies.vud_lathe.accuracy.two_by_two` found."""
    return [
        Picture("two_by_two", "Sensor and controller, two by two: share of 200 drawn axes whose error after 2 s stays "
                "below a value. Only the grating with the new controller is inside 2 um on all of them.",
                partial(two_by_two, errors)),
    ]  # fmt: skip


def two_by_two(errors: Mapping[tuple[str, str, str], np.ndarray]) -> Figure:
    """Cumulative shares, one panel for each pair of controller and sensor."""
    figure = Figure(figsize=(8.4, 5.6), layout="constrained")
    panels = figure.subplots(2, 2, sharex=True, sharey=True)
    for row, (controller, who) in zip(panels, ROWS, strict=True):
        for axes, (sensor, what) in zip(row, COLUMNS, strict=True):
            for scenario, (line, way) in LINES.items():
                found = np.sort(errors[controller, sensor, scenario])
                share = 100.0 * np.arange(1, len(found) + 1) / len(found)
                p95 = spread(found).p95
                axes.step(found, share, line, where="post", color=colour(controller),
                          label=f"{way}: 95 % below {p95:.2g} um")  # fmt: skip
            for goal in (2.0, 10.0):
                axes.axvline(goal, color="0.6", linewidth=0.8, zorder=0)
            axes.set_xscale("log")
            axes.set_xticks((0.1, 1.0, 2.0, 10.0), ("0.1", "1", "2", "10"))
            axes.set_title(f"{who}, {what}", fontsize="medium")
            axes.legend(frameon=False, loc="upper left", fontsize="small")
            axes.set_xlim(0.02, 20.0)
    for axes in panels[-1]:
        axes.set_xlabel("largest error after 2 s (um)")
    for axes in panels[:, 0]:
        axes.set_ylabel("share of the axes (%)")
    return figure
