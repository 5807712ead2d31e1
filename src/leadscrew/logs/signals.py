"""Checks of single signals: values that are no numbers, constants, zeros, a standstill, a drive at its limit.

Jumps of an encoder: steps of the position that the speed before and after does not explain.

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

from collections.abc import Mapping

import numpy as np

from leadscrew.logs.finding import Finding
from leadscrew.logs.measure import dust
from leadscrew.logs.sampling import Place

SLOW = 5e-3
"""Period in s from which one sample may hold a whole move."""

LEAST, FEW = 20, 200
"""Samples below which a log is refused, and below which it is warned of."""

LEVELS = 30
"""Different values below which a drive is switched, not clipped."""

LARGEST = 1e12
"""In SI; no log holds more, and products of what it holds stay numbers."""

NOISE_ONLY = 10.0
"""Range over standard deviation that noise alone has."""

STANDS = 5.0
"""Counts of the encoder that are no motion."""

PLACES = 6
"""Different values of a position that are no motion, chatter between counts included."""


def check_rows(count: int) -> list[Finding]:
    """Enough samples."""
    if count < LEAST:
        said = f"has {count} sample{'s' * (count != 1)}: at least {LEAST} are needed, and some 1000 for a sound fit"
        return [Finding("rows", "refused", said)]
    if count < FEW:
        return [Finding("rows", "warning", f"has only {count} samples: some 1000 are needed for a sound fit")]
    return []


def check_numbers(arrays: Mapping[str, np.ndarray], place: Place) -> list[Finding]:
    """All finite; the first that is not is named, and how many there are."""
    found = []
    for role, values in arrays.items():
        bad = np.flatnonzero(~np.isfinite(values))
        if len(bad):
            k = int(bad[0])
            what = "is empty or no number" if np.isnan(values[k]) else "is infinite"
            more = f", and {len(bad) - 1} more like it (the last {place(int(bad[-1]))})" if len(bad) > 1 else ""
            fix = (
                "cut the file to rows that are whole"
                if role == "time"
                else "take a part without with --start and --end"
            )
            found.append(Finding("number", "refused", f"{place(k)}: the {role} {what}{more}; {fix}"))
        elif len(large := np.flatnonzero(np.abs(values) > LARGEST)):
            k = int(large[0])
            said = f"{place(k)}: the {role} is {values[k]:.3g} in SI, more than {LARGEST:g}: is it the right column?"
            found.append(Finding("number", "refused", said))
    return found


def check_constant(arrays: Mapping[str, np.ndarray], step: float) -> list[Finding]:
    """Signals that never change, and a position that hardly moves."""
    names = [role for role, values in arrays.items() if role != "time" and not values.any()]
    if {"drive", "position"} <= set(names):
        return [Finding("zeros", "refused", f"{_and(names)} are 0 in every sample: nothing was recorded")]
    found = []
    position, drive = arrays["position"], arrays["drive"]
    travel = float(np.ptp(position))
    if travel == 0.0:
        said = f"the position is {position[0]:g} in every sample: the axis is at rest; record a motion with reversals"
        found.append(Finding("standstill", "refused", said))
    elif (places := _places(position)) <= PLACES:
        said = (
            f"the position takes only {places} different values within {travel:.3g}: the axis is at rest and its "
            "encoder chatters; record a motion of thousands of steps with reversals"
        )
        found.append(Finding("standstill", "refused", said))
    elif step > 0.0 and travel <= STANDS * step:
        said = (
            f"the position moves by {travel:.3g} in all, {round(travel / step)} steps of the encoder: the axis is at "
            "rest; record a motion of thousands of steps with reversals"
        )
        found.append(Finding("standstill", "refused", said))
    elif step > 0.0 and travel < 50.0 * step:
        said = (
            f"the position moves by only {round(travel / step)} steps of the encoder: its speed is little but rounding"
        )
        found.append(Finding("step", "warning", said))
    if not np.ptp(drive):
        said = f"the drive is {drive[0]:g} in every sample: it tells nothing; name its column, or record it"
        found.append(Finding("constant", "refused", said))
    for role in ("command", "velocity"):
        if role in arrays and travel > 0.0 and not np.ptp(arrays[role]):
            said = (
                f"the {role} is {arrays[role][0]:g} in every sample while the position moves: is it the right column?"
            )
            found.append(Finding("constant", "warning", said))
    return found


def _places(position: np.ndarray) -> int:
    """How many different values there are; of many, at least how many."""
    few = len(np.unique(position[:1000]))
    return few if few > PLACES else len(np.unique(position))


def check_motion(position: np.ndarray, noise: float, period: float) -> list[Finding]:
    """A position that is nothing but noise: of white noise the range of 100,000 samples is 9 standard deviations.

    Not of a slow log, in which motion from sample to sample looks like noise.
    """
    travel = float(np.ptp(position))
    if period >= SLOW or travel >= NOISE_ONLY * noise:
        return []
    said = (
        f"the position moves by {travel:.3g} in all, {travel / noise:.0f} times its noise: the axis is at rest; "
        "record a motion with reversals"
    )
    return [Finding("standstill", "refused", said)]


def check_clipped(drive: np.ndarray, time: np.ndarray, place: Place) -> list[Finding]:
    """A drive that stays at its largest or smallest value: it was limited, and its log may not say by how much.

    Not where it often stays at other values too, being held or rounded coarsely, nor where the extreme is 0.
    """
    spread = float(np.ptp(drive))
    first, lengths = _stays(drive, spread)
    limits = ("largest", drive.max()), ("smallest", drive.min())
    at = [np.abs(drive[first] - limit) <= 1e-9 * spread for _, limit in limits]
    elsewhere = ~(at[0] | at[1]) & (np.abs(drive[first]) > 1e-9 * spread)
    found = []
    for (name, limit), here in zip(limits, at, strict=True):
        enough = here.sum() >= 2 or lengths[here].max(initial=0) >= 8
        if limit == 0.0 or not enough or elsewhere.sum() >= here.sum():
            continue
        k = int(first[here][0])
        said = (
            f"the drive stays at its {name} value {limit:.5g} for {int(lengths[here].sum())} samples, first from "
            f"{place(k)} ({time[k]:.6g} s): it is clipped; right if the log shows what the drive gave, wrong if only "
            "the log was limited"
        )
        found.append(Finding("clipped", "warning", said))
    return found if len(np.unique(drive[:: max(1, len(drive) // 20_000)])) >= LEVELS else []


def _stays(values: np.ndarray, spread: float) -> tuple[np.ndarray, np.ndarray]:
    """Where stretches of three or more equal values begin, and how long they are."""
    edges = np.flatnonzero(np.abs(np.diff(values)) > 1e-9 * spread) + 1
    first = np.concatenate([[0], edges])
    lengths = np.diff(np.concatenate([first, [len(values)]]))
    return first[lengths >= 3], lengths[lengths >= 3]


def _and(names: list[str]) -> str:
    return f"{', '.join(names[:-1])} and {names[-1]}"


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
    """Which jumps lead from standstill to standstill; ``scale``: encoder step and noise.

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
        f"the position jumps {_listed(time, found, leaps, unit, place)}, from standstill to standstill: slips of "
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
