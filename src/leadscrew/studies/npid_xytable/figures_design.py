"""Pictures of the design: its map with the limits, and the paper's procedure beside ours."""

from __future__ import annotations

from functools import partial

from matplotlib.figure import Figure

from leadscrew.design.npid_compare import spectra
from leadscrew.report import npid_design
from leadscrew.studies.npid_xytable.claims_design import designed
from leadscrew.studies.npid_xytable.runs import Loops
from leadscrew.studies.study import Picture


def design_pictures(loops: Loops) -> list[Picture]:
    """Both."""
    return [
        Picture("design_map", "Our procedure on L*: the error of every slope-limited law against the PID's, the limit "
                "of the slope under command and load, the noise budget of the drive at rest, and the result.",
                partial(_map, loops)),
        Picture("design_as_paper", "Left: spectra of the error at 1000 1/min for the PID of Table I, the paper's NPID "
                "with its error in um, and our law. Right: the gain that the paper chooses and the slope that it does "
                "not look at; our map.", partial(_as_paper, loops)),
    ]  # fmt: skip


def _map(loops: Loops) -> Figure:
    return npid_design.design_map(designed(loops))


def _as_paper(loops: Loops) -> Figure:
    design = designed(loops)
    return npid_design.as_paper(design, spectra(design))
