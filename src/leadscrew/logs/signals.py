"""Checks of single signals: values that are no numbers, constants, zeros, a standstill, a drive at its limit."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from leadscrew.logs.finding import Finding
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
        said = f"the position is {position[0]:g} in every sample: the axis stands still; record a motion with reversals"
        found.append(Finding("standstill", "refused", said))
    elif (places := _places(position)) <= PLACES:
        said = (
            f"the position takes only {places} different values within {travel:.3g}: the axis stands still and its "
            "encoder chatters; record a motion of thousands of steps with reversals"
        )
        found.append(Finding("standstill", "refused", said))
    elif step > 0.0 and travel <= STANDS * step:
        said = (
            f"the position moves by {travel:.3g} in all, {round(travel / step)} steps of the encoder: the axis stands "
            "still; record a motion of thousands of steps with reversals"
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
        f"the position moves by {travel:.3g} in all, {travel / noise:.0f} times its noise: the axis stands still; "
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
