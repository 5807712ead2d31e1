"""Claims on what stands beside the network: the disturbance observer and the adaptive feed-forward of curvature."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from leadscrew.controllers.tangent.curvature_feed_forward import curvature_feed_forward
from leadscrew.controllers.tangent.curvature_network import curvature_network
from leadscrew.controllers.tangent.tangent_dob import tangent_dob
from leadscrew.report.claim import Claim
from leadscrew.studies.sofnn_tangent.chance import HALF_DIGIT
from leadscrew.studies.sofnn_tangent.changing import halves
from leadscrew.studies.sofnn_tangent.lines import PERIOD_S
from leadscrew.studies.sofnn_tangent.pieces import Pieces, pieces
from leadscrew.studies.sofnn_tangent.resight import LOST_FROM_S, moved, resight
from leadscrew.studies.sofnn_tangent.runs import Loops
from leadscrew.studies.sofnn_tangent.saying import said, word
from leadscrew.studies.sofnn_tangent.taught import DIGEST, FEEDS, STARTS, series

ROWS, BEYOND = "not in the paper; digest 7", "not in the paper; digest 8.2"
OBSERVER = (0.29, 0.26, 0.40, 1.25, 0.81, 1.84, 1.04, 0.67, 1.44)
PIECE_1 = (0.21, 0.24, 0.13, 0.71, 0.58, 0.69, 0.38, 0.31, 0.48)
PIECE_3 = (0.18, 0.20, 0.12, 0.23, 0.22, 0.44, 0.24, 0.23, 0.27)
CHANGED = {"wave": (0.23, 0.30, 0.9), "flower": (0.97, 0.95, 3.6), "rrect": (0.48, 0.74, 2.6)}
"""By line: RMS before and after the change, largest after it."""
AT_FEEDS = (0.20, 0.24, 0.36)
AT_20 = ". Below the digest's, which a texture by the sample would give: feed_forward_at_20_by_sample"


def feed_forward_claims(loops: Loops) -> list[Claim]:
    """Rows of section 7, section 8.2, and what a lost cut does."""
    parts = (_observer, _rows, _start, _settings, _changed, _fed, _resight)
    return [claim for part in parts for claim in part(loops)]


def cells_of(found: Pieces, piece: int) -> str:
    """The nine cells of a piece, in words."""
    return " ".join(f"{v:.2f}" for v in found.rms[piece - 1].mean(axis=-1).ravel())


def farthest(found: Pieces, piece: int, digest: tuple[float, ...]) -> float:
    """Largest difference of a cell from the digest's, in standard errors of the difference of two means of five."""
    rms = found.rms[piece - 1].reshape(len(digest), -1)
    error = np.hypot(np.sqrt(2.0 / rms.shape[1]) * rms.std(axis=1, ddof=1), HALF_DIGIT)
    return float(np.max(np.abs(rms.mean(axis=1) - digest) / error))


# fmt: off
def _observer(loops: Loops) -> Iterator[Claim]:
    found = pieces(loops, tangent_dob, 1)
    yield said("observer_mean", ROWS, "disturbance observer (g 0.9, gain 0.9, 0.02 s), mean RMS of the nine cells",
               found.mean(1), "deg", 0.89, f"cells {cells_of(found, 1)}; the farthest from the digest's is "
               f"{farthest(found, 1, OBSERVER):.1f} standard errors away; +-{found.spread(1):.3f} over five runs",
               tolerance=found.chance(1))
    yield said("observer_most", ROWS, "the same, mean of the largest deviation", found.largest(1), "deg", 2.9,
               "mean of the nine cells and five runs", tolerance=0.1)


def _rows(loops: Loops) -> Iterator[Claim]:
    ours, held = series(loops, "feed_forward"), series(loops, "feed_forward_digest")
    yield said("feed_forward_piece_1", ROWS, "adaptive feed-forward, first piece, mean RMS", ours.mean(1), "deg", 0.41,
               f"cells {cells_of(ours, 1)}; +-{ours.spread(1):.3f}. The digest's {0.41} is not a matter of chance: it "
               "takes the curvature before the line to be that of the first sample, which on the flower teaches all "
               f"four lags the same false thing. Read so, and with its variance 1, {held.mean(1):.2f} (flower "
               f"{held.rms[0, 1].mean():.2f}). A blade at rest has no curvature behind it", sense="<=")
    yield said("feed_forward_piece_1_held", ROWS, "the same with the digest's start", held.mean(1), "deg", 0.41,
               f"cells {cells_of(held, 1)}; what is left is in the flower alone, and depends on from which sample the "
               "digest learned", kind="report")
    yield said("feed_forward_piece_3_held", ROWS, "the same, third piece, with the digest's start", held.mean(3), "deg",
               0.24, f"cells {cells_of(held, 3)}; the farthest from the digest's is {farthest(held, 3, PIECE_3):.1f} "
               f"standard errors away; largest {held.largest(3):.2f} deg (1.2)", tolerance=held.chance(3))
    yield said("feed_forward_piece_3", ROWS, "adaptive feed-forward, third piece, mean RMS", ours.mean(3), "deg", 0.24,
               f"cells {cells_of(ours, 3)}; +-{ours.spread(3):.3f}; largest {ours.largest(3):.2f} deg (digest 1.2)",
               sense="<=", tolerance=HALF_DIGIT)
    mean, worst = ours.aside(3)
    yield said("feed_forward_lateral", ROWS, "adaptive feed-forward, third piece: largest distance of the cut from its "
               "line, mean of the nine cells", mean, "mm", 0.10, f"worst cell {worst:.2f} mm (digest 0.22; with its "
               f"start {held.aside(3)[1]:.2f})", sense="<=", tolerance=HALF_DIGIT)


def _start(loops: Loops) -> Iterator[Claim]:
    small, large = (series(loops, f"feed_forward_start_{p0:g}") for p0 in STARTS)
    yield said("feed_forward_start", BEYOND, "first flower in fabric, variance of the weights 0.03 at the start",
               small.mean(1), "deg", 0.38, f"+-{small.spread(1):.3f}; largest {small.largest(1):.1f} deg (3.0). With "
               f"10: {large.mean(1):.2f} and {large.largest(1):.1f} (digest 0.96 and 9.1; the rest is from which "
               "sample on it learned, which it does not say): a large variance believes the first noise",
               tolerance=small.chance(1))
    yield said("feed_forward_small_start", BEYOND, "a small variance at the start is better than a large one",
               word(small.mean(1) < large.mean(1) and small.largest(1) < large.largest(1)), "", "yes",
               f"{small.mean(1):.2f} against {large.mean(1):.2f} deg, largest {small.largest(1):.1f} against "
               f"{large.largest(1):.1f}; without the false curvature before the line it matters little",
               sense="yes/no")


def _settings(loops: Loops) -> Iterator[Claim]:
    two = series(loops, "feed_forward_digest")
    for preview, target in ((3, 0.25), (4, 0.31)):
        found = series(loops, f"feed_forward_preview_{preview}")
        yield said(f"feed_forward_preview_{preview}", BEYOND, f"third piece, preview {preview} samples instead of 2",
                   found.mean(3), "deg", target, f"{two.mean(3):.2f} with 2. The digest's samples; here one less, "
                   "because an offset acts in the period it is sent in; its 0 cannot be had",
                   tolerance=max(found.chance(3), 0.01))


def _changed(loops: Loops) -> Iterator[Claim]:
    for line, (before, after, most) in CHANGED.items():
        found = halves(loops, DIGEST, line)
        first, second, largest = found.judged()
        chance = 3.0 * np.sqrt(2.0 / 5.0) * found.spread()[1] + HALF_DIGIT
        yield said(f"feed_forward_changed_{line}", ROWS, f"{line}, fabric, from half on foam, first piece: RMS after "
                   "the change", second, "deg", after, f"+-{found.spread()[1]:.3f}; before {first:.2f} ({before}), "
                   f"largest after {largest:.1f} ({most}). " + ("The digest's start, which spoils its first flower, is "
                   "in both halves" if line == "flower" else "The digest's start"), sense="<=", tolerance=chance)


def _fed(loops: Loops) -> Iterator[Claim]:
    for feed, target in zip(FEEDS, AT_FEEDS, strict=True):
        found = series(loops, f"feed_forward_at_{feed:g}")
        yield said(f"feed_forward_at_{feed:g}", ROWS, f"second flower in fabric at {feed:g} mm/s, feed-forward",
                   found.mean(2), "deg", target, f"+-{found.spread(2):.3f}. The lags stay in samples, the texture in "
                   "mm; preview does not fade with the feed as feedback does" + AT_20 * (feed == 20.0),
                   tolerance=found.chance(2), kind="required" if feed == 50.0 else "report")
    found = series(loops, "feed_forward_slow_by_sample")
    yield said("feed_forward_at_20_by_sample", ROWS, "the same at 20 mm/s in a texture that changes from sample to "
               "sample as at 50 mm/s", found.mean(2), "deg", AT_FEEDS[0], f"+-{found.spread(2):.3f}. As of the tuned "
               "network (feed_sofnn_tuned_20_by_sample): the digest seems to have kept its texture in samples",
               tolerance=found.chance(2))


def _resight(loops: Loops) -> Iterator[Claim]:
    count = len(LOST_FROM_S)
    for key, words, block in (("feed_forward", "adaptive feed-forward", curvature_feed_forward),
                              ("rules", "rules of the curvature", curvature_network)):
        found = resight(loops, block)
        once = moved(loops, block(return_s=PERIOD_S))
        yield said(f"resight_{key}", "not in the paper", f"{words}: largest change of the offset from one sample to "
                   f"the next when the cut is seen again, {count} losses of a second, flower in foam",
                   found.seen_again, "deg", found.plain, f"{found.plain:.2f} deg at most where nothing is lost. What "
                   f"is read comes back in {block.params.return_s:g} s; with all of it at once "
                   f"{once:.1f} deg", sense="<=")
    found = resight(loops, tangent_dob)
    yield said("resight_observer", "not in the paper", "the same, disturbance observer", found.seen_again, "deg", None,
               f"{found.plain:.2f} deg where nothing is lost. It takes a number and is not told: it goes on from a "
               "reading that stands still, and winds up as a PID does", kind="report")
# fmt: on
