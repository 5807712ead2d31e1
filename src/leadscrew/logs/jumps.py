"""Jumps of an encoder: steps of the position that the speed before and after does not explain.

A step stands out by how far it lies beyond the range of its two neighbours on either side: a start or a stop lies
within it, and so does any motion that lasts three samples. It is a jump where that is far more than usual in this
log, more than four counts, more than the noise and more than a twentieth of the fastest steps. In a log slower than
200 Hz, where a short move takes one sample, it must be more than twice the usual steps, and is a warning. Where the
command jumps along, it is the record that is not whole.

A slip of stick-slip stands out too: the axis leaps within a few samples as its friction lets go. It begins and ends at
rest, where a fault of the encoder in motion leaves the speed before and after as it was. So a step from stand-still to
stand-still is warned of and not refused, and said with how often the drive had been rising that way, as it does before
a slip. One bad sample, gone in the next, is no slip, nor is a step within one sample of a log of 2 kHz or faster.
"""

from __future__ import annotations

import numpy as np

from leadscrew.logs.finding import Finding
from leadscrew.logs.measure import dust
from leadscrew.logs.sampling import Place
from leadscrew.logs.signals import SLOW

FAR = 8.0
"""How many times further than the 90th percentile a jump stands out."""

MOST = 0.1
"""Share of samples above which what stands out is the motion itself, not jumps."""

SLIP = 5e-4
"""Period in s up to which a slip takes two samples or more: one of a stage of 0.37 g m^2 lasts 1.25 ms."""

BEFORE, AFTER, LOOK = 2, 5, 8
"""Samples that a slip may have begun before it stands out, that it may last after, and that are looked at for rest."""


def excess(position: np.ndarray) -> np.ndarray:
    """How far every step lies beyond the range of its two neighbours on either side, signed; 0 at the ends."""
    steps = np.diff(position)
    padded = np.concatenate([steps[:1], steps[:1], steps, steps[-1:], steps[-1:]])
    around = np.stack([padded[k : k + len(steps)] for k in (0, 1, 3, 4)])
    low, high = around.min(axis=0), around.max(axis=0)
    beyond = np.maximum(steps - high, 0.0) + np.minimum(steps - low, 0.0)
    # What comes before the first and after the last is not known.
    beyond[:2] = beyond[-2:] = 0.0
    return np.asarray(beyond)


def jumps(position: np.ndarray, period: float, step: float, noise: float) -> tuple[np.ndarray, np.ndarray]:
    """Indices of the samples that a jump leads to, and its size, signed."""
    beyond = excess(position)
    size, steps = np.abs(beyond), np.abs(np.diff(position))
    usual = 2.0 * float(np.quantile(steps, 0.9)) if period >= SLOW else 0.05 * float(np.quantile(steps, 0.999))
    limit = max(FAR * float(np.quantile(size, 0.9)), 4.5 * step, 12.0 * noise, usual, dust(position))
    found = np.flatnonzero(size > limit)
    if len(found) > max(MOST * len(position), 2):
        found = found[:0]
    around = np.median([np.diff(position)[np.clip(found + k, 0, len(steps) - 1)] for k in (-2, -1, 1, 2)], axis=0)
    return found + 1, np.diff(position)[found] - around if len(found) else np.zeros(0)


def slips(
    position: np.ndarray, period: float, found: np.ndarray, sizes: np.ndarray, scale: tuple[float, float]
) -> np.ndarray:
    """Which jumps lead from stand-still to stand-still; ``scale``: encoder step and noise.

    Eight samples before and after, those up to the next jump, may move by 2.5 counts, 6 times the noise or a hundredth
    of the jump, on one of the two sides by a twentieth (the bristles give before they let go).
    """
    rests = np.zeros(len(found), dtype=bool)
    for at, k in enumerate(found):
        last = int(found[at - 1]) if at else -AFTER
        following = int(found[at + 1]) if at + 1 < len(found) else len(position) + BEFORE
        low = max(0, int(k) - BEFORE - LOOK, last + AFTER)
        high = min(len(position) - 1, int(k) + AFTER + LOOK, following - BEFORE)
        before, after = position[low : max(k - BEFORE, 0) + 1], position[k + AFTER : high + 1]
        back = at + 1 < len(found) and found[at + 1] == k + 1 and sizes[at] * sizes[at + 1] < 0.0
        back |= at > 0 and found[at - 1] == k - 1 and sizes[at] * sizes[at - 1] < 0.0
        if len(before) < 3 or len(after) < 3 or back:
            continue
        leap = abs(float(after[0] - before[-1]))
        second = np.sort(np.abs(np.diff(position[k - BEFORE : k + AFTER + 1])))[-2]
        if period <= SLIP and second < 0.02 * leap + scale[0]:
            continue
        still = max(2.5 * scale[0], 6.0 * scale[1], 0.01 * leap)
        moved = sorted((float(np.ptp(before)), float(np.ptp(after))))
        rests[at] = moved[0] <= still and moved[1] <= max(still, 0.05 * leap)
    return rests


def _slip(
    time: np.ndarray, position: np.ndarray, drive: np.ndarray, found: np.ndarray, unit: str, place: Place
) -> Finding:
    """Warns of jumps between stand-stills, with how to tell a slip from a fault."""
    first, last = np.maximum(found - BEFORE, 0), np.minimum(found + AFTER, len(position) - 1)
    leaps = position[last] - position[first]
    rose = sum(
        _rise(drive[: max(k - BEFORE + 1, 1)]) * leap > 0.0 for k, leap in zip(found.tolist(), leaps, strict=True)
    )
    said = (
        f"the position jumps {_listed(time, found, leaps, unit, place)}, from stand-still to stand-still: slips of "
        f"the axis if the drive rose that way before them (it did before {rose} of {len(found)}), which the fit can "
        "use; else the encoder lost counts: check it and its cable"
    )
    return Finding("slip", "warning", said)


def _rise(drive: np.ndarray) -> float:
    """By how much the last samples lie above those somewhat earlier."""
    return float(drive[-LOOK // 2 :].mean() - drive[-4 * LOOK : max(len(drive) - 2 * LOOK, 1)].mean())


def check_jumps(
    time: np.ndarray,
    position: np.ndarray,
    drive: np.ndarray,
    command: np.ndarray | None,
    scale: tuple[float, float],
    unit: str,
    place: Place,
) -> list[Finding]:
    """Jumps of the position, and those of position and command together; ``scale``: encoder step and noise."""
    period = float(time[-1] - time[0]) / (len(time) - 1)
    found, sizes = jumps(position, period, *scale)
    if not len(found):
        return []
    turn = 2.0 * np.pi
    if unit == "rad" and np.all(np.abs(np.abs(sizes) - turn) < 0.05 * turn):
        many = "" if len(found) == 1 else f" {len(found)} times, first"
        said = f"the angle turns over by a whole turn{many} at {place(int(found[0]))}: unwrap it (numpy.unwrap)"
        return [Finding("jump", "refused", said)]
    along = np.zeros(len(found), dtype=bool)
    if command is not None:
        along = np.abs(excess(command)[found - 1]) > 0.5 * np.abs(sizes)
    slipped = ~along & slips(position, period, found, sizes, scale)
    low, high = _stretch(found[~slipped], len(position))
    part = f"the longest part without is --start {time[low]:.6g} --end {time[high]:.6g}"
    findings = []
    alone = ~along & ~slipped
    if alone.any():
        listed = _listed(time, found[alone], sizes[alone], unit, place)
        said = f"the position jumps {listed}, which its speed before and after does not explain: {{}}; {part}"
        cause = "check the encoder and its cable"
        sure = period < SLOW
        if not sure:
            cause = "a short move between two samples, or a fault of the encoder: record faster"
        findings.append(Finding("jump", "refused" if sure else "warning", said.format(cause)))
    if slipped.any():
        findings.append(_slip(time, position, drive, found[slipped], unit, place))
    if along.any():
        listed = _listed(time, found[along], sizes[along], unit, place)
        said = f"position and command jump together {listed}: the record leaves out time there, or rows; {part}"
        findings.append(Finding("record", "warning", said))
    return findings


def _listed(time: np.ndarray, found: np.ndarray, sizes: np.ndarray, unit: str, place: Place) -> str:
    """``twice, by ...``: a sample that jumps away and one that jumps back are one bad sample."""
    back = np.flatnonzero((np.diff(found) == 1) & (np.abs(sizes[1:] + sizes[:-1]) < 0.2 * np.abs(sizes[1:])))
    kept = np.ones(len(found), dtype=bool)
    kept[back + 1] = False
    alone = set(found[back].tolist())
    named = "; ".join(
        f"{size:+.3g} {unit} at {place(int(k))} ({time[k]:.6g} s{', back in the next' if int(k) in alone else ''})"
        for k, size in list(zip(found[kept], sizes[kept], strict=True))[:3]
    )
    count = int(kept.sum())
    more = f"; and {count - 3} more" if count > 3 else ""
    return f"{'once' if count == 1 else f'{count} times'}, by {named}{more}"


def _stretch(found: np.ndarray, samples: int) -> tuple[int, int]:
    edges = np.concatenate([[0], found, [samples]])
    at = int(np.argmax(np.diff(edges)))
    return int(edges[at]), int(edges[at + 1]) - 1
