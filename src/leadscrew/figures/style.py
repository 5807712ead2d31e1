"""How plots look everywhere: one colour a controller, one line a kind of source.

Colours are those of Okabe and Ito (*Color Universal Design*, 2008), told apart with every common colour blindness.
Lines say whose result it is: dotted what the paper says, dashed the paper's controller as printed, solid corrected or
ours.
"""

from __future__ import annotations

from typing import TYPE_CHECKING
from zlib import crc32

if TYPE_CHECKING:
    pass

BLACK, ORANGE, SKY, GREEN, YELLOW, BLUE, VERMILION, PURPLE = (
    "#000000", "#E69F00", "#56B4E9", "#009E73", "#F0E442", "#0072B2", "#D55E00", "#CC79A7",
)  # fmt: skip

LINES = {"paper says": ":", "paper": "--", "corrected": "-", "ours": "-"}
"""Line style by the part of a controller's name before the dot."""

COLOURS = {
    "paper says": BLACK,
    "paper.vud": VERMILION,
    "corrected.vud_beta_e": BLUE,
    "corrected.vud_beta_e_half": SKY,
    "ours.original_fit": ORANGE,
    "ours.pd": GREEN,
    "ours.vud_opt": PURPLE,
    "ours.vud_fast": BLACK,
    "corrected.smc": VERMILION,
    "paper.smc": ORANGE,
    "paper.csmc": BLUE,
    "corrected.fsmc": GREEN,
    "paper.fsmc": SKY,
    "ours.smc_4khz": VERMILION,
    "ours.csmc_4khz": BLUE,
    "ours.fsmc_4khz": GREEN,
    "ours.pid": ORANGE,
    "ours.pd_dob": PURPLE,
    "ours.pd_learned": BLACK,
    "paper.pid": VERMILION,
    "corrected.npid_um": BLUE,
    "ours.npid_slope": SKY,
    "ours.npid_slope_159": PURPLE,
    "ours.npid_split": BLUE,
    "ours.pid_ms_159": ORANGE,
    "ours.pid_ms_185": PURPLE,
    "ours.pid_dob_60": SKY,
    "ours.cascade": GREEN,
    "ours.learned": BLACK,
    "ours.pid_159_ff": GREEN,
    "ours.resonant_full": BLACK,
    "corrected.tfc_s6": VERMILION,
    "corrected.gpfc_b_s6": BLUE,
    "corrected.gpfc_a_s6": SKY,
    "ours.two_point_s6": GREEN,
    "corrected.tfc_s9": VERMILION,
    "corrected.gpfc_b_s9": BLUE,
    "corrected.gpfc_a_s9": SKY,
    "ours.two_point_s9": GREEN,
    "corrected.tfc_s9_half": VERMILION,
    "corrected.gpfc_b_s9_half": BLUE,
    "corrected.gpfc_a_s9_half": SKY,
    "ours.two_point_s9_half": GREEN,
    "corrected.tfc_stfc": VERMILION,
    "corrected.gpfc_b_stfc": BLUE,
    "corrected.gpfc_a_stfc": SKY,
    "ours.two_point_stfc": GREEN,
    "corrected.gpfc_b_sg": BLUE,
    "ours.smith_f": PURPLE,
    "ours.smith_n": PURPLE,
    "paper.gpfc_printed_s9": ORANGE,
    "ours.tfc_ff": BLUE,
    "ours.gain_normalised": GREEN,
    "ours.inversion": PURPLE,
    "ours.constant_force": BLACK,
    "paper.uncompensated": BLACK,
    "corrected.fnn": VERMILION,
    "corrected.sofnn_table": SKY,
    "paper.sofnn_pnn": BLUE,
    "ours.sofnn_tuned": GREEN,
    "corrected.sofc": PURPLE,
}
"""Colour by controller, kept across all figures; others get one of the rest by their name."""

_OTHERS = (PURPLE, GREEN, ORANGE, SKY, BLUE, VERMILION)


def colour(controller: str) -> str:
    """The colour of a controller, the same in every figure and every session."""
    return COLOURS.get(controller) or _OTHERS[crc32(controller.encode()) % len(_OTHERS)]


def line(controller: str) -> str:
    """The line style of a controller: by whose it is."""
    return LINES.get(controller.split(".")[0], "-")


def pen(controller: str, label: str | None = "") -> dict[str, str | None]:
    """Keyword arguments for a plotted line: ``axes.plot(t, x, **pen("paper.vud"))``; the label is the name."""
    return {"color": colour(controller), "linestyle": line(controller), "label": controller if label == "" else label}
