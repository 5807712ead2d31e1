"""M6: from a drawing to a compensated program by the scan of one piece, without a sensor on the machine."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from leadscrew.report.claim import Claim
from leadscrew.studies.sofnn_tangent import workflow as w
from leadscrew.studies.sofnn_tangent.lines import LAPS, MATERIAL_NAMES
from leadscrew.studies.sofnn_tangent.runs import Loops
from leadscrew.studies.sofnn_tangent.saying import said

SOURCE = "not in the paper; digest 8.5, M6; acceptance 1 of the issue"
THIRD = 1.0 / 3.0
NAMES = {
    "wave": "the wave", "flower": "the flower", "rrect": "the rounded rectangle",
    "leaf.svg": "an SVG of nested transforms, Bezier curves, an ellipse and a rounded rectangle",
    "petal.dxf": "a DXF in inches with a spline in a turned block and bulges",
}  # fmt: skip
LIVE = NAMES | {"cushion.ngc": "a G-code program of lines and arcs without tangential words"}
SHORT = {"leaf.svg": "svg", "petal.dxf": "dxf", "cushion.ngc": "gcode"}


def workflow_claims(loops: Loops) -> list[Claim]:
    """Acceptance 1 (M6), a scan as it is, other materials, further pieces, and what an unmarked scan loses."""
    del loops
    return [*_exact(), *_scanned(), *_kept(), *_words()]


# fmt: off
def _exact() -> Iterator[Claim]:
    for drawing, name in LIVE.items():
        found = w.trip(drawing)
        runs = f"; in {len(w.SEEDS)} runs {_spread(drawing)}" if drawing in NAMES else ""
        yield said(f"m6_{SHORT.get(drawing, drawing)}", SOURCE, "error of the second piece by that of the first, "
                   f"{name}, fabric: drawing to G-code, cut, cut line to a file, compensated G-code, cut again",
                   found.ratio, "", THIRD,
                   f"one run, {found.errors[0]:.2f} then {found.errors[1]:.2f} deg rms, each piece with a texture of "
                   f"its own{runs}; offsets up to {found.largest:.1f} deg; the cut line is known without noise, to 0.1 "
                   "um", sense="<=")


def _spread(drawing: str) -> str:
    each = w.each_ratio((drawing,), ("fabric",), "exact")
    return f"{each.min():.2f} to {each.max():.2f}, mean {each.mean():.2f}"


def _scanned() -> Iterator[Claim]:
    for drawing in LAPS:
        found = w.trip(drawing, scan="scanner")
        away = float(np.hypot(*w.PLACED[:2]))
        yield said(f"m6_scan_{drawing}", SOURCE, f"the same, {NAMES[drawing]}, from a scan with {w.NOISE_MM:g} mm of "
                   f"noise on a piece that lay turned by {w.PLACED[2]:g} deg and {away:.0f} mm away, brought back by "
                   "two marks that have the noise too", found.ratio, "", THIRD,
                   f"{found.errors[0]:.2f} then {found.errors[1]:.2f} deg rms", sense="<=", kind="moonshot")


def _kept() -> Iterator[Claim]:
    drawings = tuple(NAMES)
    table = w.kept_table()
    runs = f"{len(drawings)} drawings in {len(MATERIAL_NAMES)} materials, {len(w.SEEDS)} runs each"
    exact, scanner, shape = (w.ratios(drawings, MATERIAL_NAMES, scan) for scan in ("exact", "scanner", "shape"))
    each = w.each_ratio(drawings, MATERIAL_NAMES, "exact")
    worst = each[np.unravel_index(int(exact.argmax()), exact.shape)]
    error = float(worst.std(ddof=1) / np.sqrt(len(worst)))
    over = int((each > THIRD).sum())
    yield said("m6_worst", SOURCE, f"the largest of the ratios of {runs}, means over the runs, exact cut line",
               float(exact.max()), "", THIRD,
               f"mean {exact.mean():.2f}; largest for {_where(exact)}, where there is least to gain: {worst.min():.2f} "
               f"to {worst.max():.2f} in its {len(worst)} runs. Their mean has a standard error of {error:.3f} "
               f"and lies {THIRD - exact.max():.3f} below the third. Single runs: m6_worst_run",
               sense="<=", kind="moonshot")
    yield said("m6_worst_run", SOURCE, "the largest ratio of a single run of those, exact cut line", float(each.max()),
               "", THIRD, f"{over} of {each.size} runs miss the third; mean {each.mean():.2f}", sense="<=",
               kind="report")
    where = np.unravel_index(int(scanner.argmax()), scanner.shape)
    case = drawings[where[0]], MATERIAL_NAMES[where[1]]
    left, known = (float(table[*case, scan].mean(axis=0)[1]) for scan in ("scanner", "exact"))
    yield said("m6_scan_worst", SOURCE, "the same from scans with noise, aligned by marks", float(scanner.max()), "",
               THIRD, f"mean {scanner.mean():.2f}; {int((scanner <= THIRD).sum())} of {scanner.size} reach a third; "
               f"largest for {_where(scanner)}: the first piece is off by {_first(scanner):.2f} deg only, the second "
               f"by {left:.2f}, of which the texture that does not come again leaves {known:.2f} even where the cut "
               "line is known exactly", sense="<=", kind="report")
    yield said("m6_shape_worst", SOURCE, "the same scans, aligned by the shape of the cut instead of marks",
               float(shape.max()), "", THIRD, f"mean {shape.mean():.2f}; {int((shape <= THIRD).sum())} of {shape.size} "
               "reach a third: the angle by which a whole cut is off cannot be told from how the piece lay, and stays",
               sense="<=", kind="report")
    third = [table[d, m, "scanner"].mean(axis=0) for d in drawings for m in MATERIAL_NAMES]
    share = float(np.mean([row[2] / row[0] for row in third]))
    foam = float(np.mean([table[d, "foam", "scanner"].mean(axis=0)[2] / table[d, "foam", "scanner"].mean(axis=0)[0]
                          for d in drawings]))
    yield said("m6_third_piece", SOURCE, "error of the third piece by that of the first, mean of the same, scans with "
               "noise and marks", share, "", None, f"second piece {scanner.mean():.2f}; in foam, whose gain of 0.75 is "
               f"furthest from the believed 0.9, {scanner[:, MATERIAL_NAMES.index('foam')].mean():.2f} then {foam:.2f}",
               kind="report")


def _where(ratios: np.ndarray) -> str:
    drawing, material = np.unravel_index(int(ratios.argmax()), ratios.shape)
    return f"{tuple(NAMES)[drawing]} in {MATERIAL_NAMES[material]}"


def _first(ratios: np.ndarray) -> float:
    drawing, material = np.unravel_index(int(ratios.argmax()), ratios.shape)
    return float(w.kept_table()[tuple(NAMES)[drawing], MATERIAL_NAMES[material], "exact"].mean(axis=0)[0])


def _words() -> Iterator[Claim]:
    from leadscrew.tangent.program import program_of
    from leadscrew.tangent.settings import Settings

    path = w.paths_of("flower")[0]
    (read,) = program_of(w.first_program("flower")).strokes
    assert read.words is not None
    s = np.linspace(0.0, read.length, 20001)
    off = np.interp(s, *read.words) - path.at(s * path.length / read.length).heading
    moves = sum(w.first_program("flower").count(f"\n{word} X") for word in ("G1", "G2", "G3"))
    plain = Settings()
    yield said("m6_words", SOURCE, "largest angle between the blade of the program for the flower and the tangent of "
               "the curve, anywhere on the line", float(np.abs(off - np.round(off / 360.0) * 360.0).max()), "deg",
               plain.angle_tolerance, f"{moves} moves within {plain.tolerance:g} mm; the words are the tangents of "
               "the curve itself, and between two words the axis turns evenly", tolerance=0.01, sense="<=")
