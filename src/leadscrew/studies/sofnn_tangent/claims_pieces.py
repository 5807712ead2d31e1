"""Claims on learning from piece to piece: digest 8.1 and 8.4, and what section 7 says of it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from leadscrew.report.claim import Claim
from leadscrew.studies.sofnn_tangent.chance import HALF_DIGIT
from leadscrew.studies.sofnn_tangent.pieces import MISMATCH
from leadscrew.studies.sofnn_tangent.runs import Loops
from leadscrew.studies.sofnn_tangent.saying import said, word
from leadscrew.studies.sofnn_tangent.taught import SWAP_AT, series

ROWS, BEYOND, WRONG = "not in the paper; digest 7", "not in the paper; digest 8.1", "not in the paper; digest 8.4"

Row = tuple[str, str, int, float]
"""Name of the claim, words, piece, mean RMS of the digest."""
MEANS: dict[str, tuple[Row, ...]] = {
    "table_wide": (
        ("table_piece_3", "the table alone, sigma 4 samples, third piece", 3, 0.37),
        ("table_piece_6", "the table alone, sigma 4 samples, sixth piece", 6, 0.30),
    ),
    "net_table": (
        ("net_table_piece_3", "the paper's SOFNN with the table, third piece", 3, 0.25),
        ("net_table_piece_6", "the paper's SOFNN with the table, sixth piece", 6, 0.22),
    ),
}
FLOWER = {
    "table": ("the table alone", (2.67, 0.52, 0.28, 0.27)),
    "net_table": ("the paper's SOFNN with the table", (1.83, 0.41, 0.24, 0.23)),
    "tuned_table": ("the tuned SOFNN with the table", (1.00, 0.40, 0.31)),
    "net_textbook": ("the paper's SOFNN with the textbook update", (1.83, 1.03, 0.63, 0.32)),
}
"""Flower in fabric, pieces 1, 2, 3, 6."""
SWAPPED = {
    "swap_table": ("the table alone", (0.25, 2.39, 0.84, 0.31, 0.20)),
    "swap_tuned_table": ("the tuned SOFNN with the table", (0.28, 0.81, 0.29, 0.18, 0.15)),
    "swap_feed_forward": ("the adaptive feed-forward", (0.22, 0.83, 0.48, 0.44, 0.44)),
}
"""Flower, from fabric to foam at the fifth piece: pieces 4 to 8."""
UNKNOWN: dict[str, tuple[str, tuple[tuple[int, float, float | None], ...]]] = {
    "fixed": ("fixed network", ((1, 1.28, None),)),
    "net": ("the paper's SOFNN", ((1, 0.91, None),)),
    "tuned": ("tuned SOFNN", ((1, 0.50, 1.7),)),
    "pid": ("PID 0.7, 14, 0.005", ((1, 0.52, 1.7),)),
    "feed_forward": ("adaptive feed-forward", ((1, 0.39, 1.4), (3, 0.35, 1.2))),
    "table": ("the table alone, sigma 4", ((3, 0.29, 0.9),)),
    "net_table": ("the paper's SOFNN with the table", ((3, 0.23, 0.8), (6, 0.22, 0.7))),
}
"""With what no controller knows of: piece, mean RMS, mean of the largest."""
FIRST_OF = {"net": "net_table"}
"""Without a table is the first piece of the series with one."""


def pieces_claims(loops: Loops) -> list[Claim]:
    """All of them."""
    return [*_means(loops), *_lateral(loops), *_flower(loops), *_swapped(loops), *_unknown(loops)]


# fmt: off
def _means(loops: Loops) -> Iterator[Claim]:
    for name, rows in MEANS.items():
        found = series(loops, name)
        for key, words, piece, target in rows:
            cells = " ".join(f"{v:.2f}" for v in found.rms[piece - 1].mean(axis=-1).ravel())
            yield said(key, ROWS, f"{words}: mean RMS of the nine cells", found.mean(piece), "deg", target,
                       f"cells {cells}; +-{found.spread(piece):.3f} from run to run, largest "
                       f"{found.largest(piece):.2f} deg", tolerance=max(found.chance(piece), 0.01))
    wide, narrow = series(loops, "table_wide"), series(loops, "table")
    yield said("table_narrow", BEYOND, "the table alone with sigma 1.5 samples, sixth piece", narrow.mean(6), "deg",
               wide.mean(6), f"+-{narrow.spread(6):.3f}; sigma 4 rounds the fillets off and stays at "
               f"{wide.mean(6):.2f}", sense="<=")


def _lateral(loops: Loops) -> Iterator[Claim]:
    net, tuned = series(loops, "net_table"), series(loops, "tuned_table")
    mean, worst = net.aside(3)
    yield said("net_table_lateral", ROWS, "the paper's SOFNN with the table, third piece: largest distance of the cut "
               "from its line, mean of the nine cells, unbiased camera", mean, "mm", 0.12, f"worst cell {worst:.2f} mm "
               f"(digest 0.16); without the table {net.aside(1)[0]:.2f}", tolerance=0.02)
    mean, worst = tuned.aside(2)
    runs = tuned.lateral[1].mean(axis=(0, 1))
    spread = float(runs.std(ddof=1))
    apart = (mean - 0.08) / (spread * float(np.sqrt(1 / runs.size + 1 / 3)))
    yield said("tuned_table_lateral", ROWS, "the tuned SOFNN with the table, second piece: the same", mean, "mm", 0.08,
               f"worst cell {worst:.2f} mm (digest 0.12), {100.0 * (mean / 0.08 - 1.0):.0f} % more than the digest's; "
               f"runs {' '.join(f'{v:.2f}' for v in runs)}: {apart:.1f} standard errors between five runs and the "
               f"digest's three, too few to tell. Third piece {tuned.aside(3)[0]:.2f}", kind="report")


def _flower(loops: Loops) -> Iterator[Claim]:
    for name, (words, digest) in FLOWER.items():
        found = series(loops, name)
        at = (0, 0) if found.rms.shape[1] == 1 else (1, 0)
        shown = [1, 2, 3, 6][: len(digest)]
        runs = found.rms[:, at[0], at[1]]
        values = runs.mean(axis=-1)
        last = shown[-1]
        chance = 3.0 * np.sqrt(2.0 / runs.shape[1]) * float(runs[last - 1].std(ddof=1)) + HALF_DIGIT
        said_all = " ".join(f"{values[k - 1]:.2f}" for k in shown)
        theirs = " ".join(f"{v:.2f}" for v in digest)
        yield said(f"flower_{name}", BEYOND, f"flower in fabric, {words}: RMS of piece {last}", values[last - 1], "deg",
                   digest[-1], f"pieces {', '.join(map(str, shown))}: {said_all} (digest {theirs}); +-"
                   f"{runs[last - 1].std(ddof=1):.3f}", tolerance=chance,
                   kind="report" if name == "net_textbook" else "required")
    net, book = (series(loops, k).rms[:, i, 0].mean(axis=-1) for k, i in (("net_table", 1), ("net_textbook", 0)))
    yield said("textbook_slower", BEYOND, "with feedback on, the textbook update is slower than the command form",
               word(bool(book[1] > 1.5 * net[1] and book[2] > 1.5 * net[2])), "", "yes", f"flower in fabric, second "
               f"and third piece: {book[1]:.2f} and {book[2]:.2f} deg against {net[1]:.2f} and {net[2]:.2f}. It waits "
               "for what the feedback leaves over; our L is not divided by g", sense="yes/no")


def _swapped(loops: Loops) -> Iterator[Claim]:
    for name, (words, digest) in SWAPPED.items():
        found = series(loops, name)
        values = found.rms[SWAP_AT - 2 :, 0, 0].mean(axis=-1)
        runs = found.rms[SWAP_AT, 0, 0]
        off = float(np.max(np.abs(values - digest)))
        yield said(name, BEYOND, f"flower, foam from the fifth piece on, {words}: RMS of the sixth piece", values[2],
                   "deg", digest[2], f"pieces 4 to 8: {' '.join(f'{v:.2f}' for v in values)} (digest "
                   f"{' '.join(f'{v:.2f}' for v in digest)}); largest difference {off:.2f}",
                   tolerance=3.0 * float(np.sqrt(2.0 / runs.size) * runs.std(ddof=1)) + HALF_DIGIT)


def _unknown(loops: Loops) -> Iterator[Claim]:
    none = series(loops, "mismatch_table")  # its first table is empty
    sizes = ", ".join(f"{key.removeprefix('plant.')} {value:g}" for key, value in MISMATCH.items())
    yield said("mismatch_none", WRONG, "with what no controller knows of, no compensation: mean RMS of the nine cells",
               none.mean(1), "deg", 1.45, f"Fitted: {sizes} (the digest gives no sizes); largest {none.largest(1):.2f} "
               "deg (3.5)", tolerance=0.02, kind="report", basis="fitted to this number")
    for name, (words, rows) in UNKNOWN.items():
        found = series(loops, f"mismatch_{FIRST_OF.get(name, name)}")
        for piece, target, most in rows:
            yield said(f"mismatch_{name}_{piece}", WRONG, f"the same, {words}, piece {piece}", found.mean(piece), "deg",
                       target, f"+-{found.spread(piece):.3f}, largest {found.largest(piece):.2f} deg"
                       + (f" ({most})" if most else "") + ". Not the digest's sizes: see mismatch_none",
                       kind="report")
    ahead, table = series(loops, "mismatch_feed_forward"), series(loops, "mismatch_table")
    both = series(loops, "mismatch_net_table")
    yield said("mismatch_order", WRONG, "feed-forward loses its lead where its structure is wrong, learning from piece "
               "to piece does not", word(both.mean(3) < table.mean(3) < ahead.mean(3)), "", "yes",
               f"third piece: feed-forward {ahead.mean(3):.2f}, table {table.mean(3):.2f}, table and SOFNN "
               f"{both.mean(3):.2f} deg", sense="yes/no")
# fmt: on
