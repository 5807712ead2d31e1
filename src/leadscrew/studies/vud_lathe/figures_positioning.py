"""The positioning tests of the study as a picture."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from matplotlib.figure import Figure

from leadscrew.analysis.positioning import Positioning
from leadscrew.report.positioning import draw
from leadscrew.studies.study import Picture

PANELS = {"encoder": "encoder", "compensated": "encoder, compensated", "grating": "grating"}


def positioning_pictures(tests: Mapping[str, Positioning]) -> list[Picture]:
    """The picture of the tests that ``positioning_test.positioning_tests`` made."""
    return [
        Picture("iso_230_2", "Positioning test of ISO 230-2, simulated: true deviations of the table behind the "
                "encoder, behind the encoder with the compensation table of the first test, and behind the grating "
                "(each panel has its own scale).", partial(three_tests, tests)),
    ]  # fmt: skip


def three_tests(tests: Mapping[str, Positioning]) -> Figure:
    """Deviation against target, a panel for each test."""
    figure = Figure(figsize=(10.6, 4.2), layout="constrained")
    panels = figure.subplots(1, len(PANELS))
    for axes, (name, title) in zip(panels, PANELS.items(), strict=True):
        test = tests[name]
        assert test.both is not None
        draw(axes, test)
        axes.set_title(
            f"{title}\nA = {test.both.accuracy:.2g} µm, R = {test.both.repeatability:.2g} µm", fontsize="medium"
        )
    for axes in panels[1:]:
        axes.set_ylabel("")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=5, frameon=False, fontsize="small")
    return figure
