"""What constant force is for: how fast a bar is turned, and at which peak force, against a constant feed.

Two bars of 40 mm, four stretches of 10 mm each, at 1,200 1/min and 50 mm diameter; the edge stands at the bar and the
feed starts from rest. The shoulders are not announced to the controllers:

    falling    1.0, 0.8, 0.6, 0.4 mm                                   the depths of section 5.2
    mixed      0.6, 1.0, 0.4, 0.8 mm, the last 25 % harder

A constant feed has one number. It is compared at **equal peak force**: the feed whose peak on this bar, entry and
runout included, is that of the controller. ``Account.gain`` above 1 means that the controller is done sooner.

Fixed removal rate: the tuned TFC on the force, the spindle speed regulated to 92.9 mm^3/s, what 150 N at 1 mm and 1,200
1/min remove (:obj:`leadscrew.controllers.lathe_loops`); this one knows the raw part.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from leadscrew.plants._turning.workpiece import stretches
from leadscrew.studies.grey_turning.lathe import RECORD, constant_feed, force_law, running, three_loops, whole_lathe
from leadscrew.studies.grey_turning.scenarios import FORCE_N, PERIOD_S
from leadscrew.studies.grey_turning.tunings import FORCE
from leadscrew.studies.lab import Lab, measure

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

LENGTH_MM, STRETCH_MM, DIAMETER_MM = 40.0, 10.0, 50.0
LIMIT_N = 1.1 * FORCE_N
"""Force above which time is counted."""
DEPTHS = {"falling": (1.0, 0.8, 0.6, 0.4), "mixed": (0.6, 1.0, 0.4, 0.8)}
HARDER = {"falling": (0.0, 0.0, 0.0, 0.0), "mixed": (0.0, 0.0, 0.0, 0.25)}
FIXED_RATE = math.pi * DIAMETER_MM * 35.5 / 60.0
"""Removal rate at 1 mm and 35.5 mm/min, mm^3/s."""
FEEDS = tuple(np.geomspace(33.0, 150.0, 6).tolist())
"""Constant feeds that are tried, mm/min."""
FUZZY = ("corrected.tfc_s9", "corrected.gpfc_b_s9", "corrected.tfc_stfc", "corrected.gpfc_b_sg")
REGULATED, OURS = "fixed removal rate", "ours.constant_force"
TUNED = ("corrected.tfc_stfc", "corrected.gpfc_b_sg", OURS)
SEEDS = 2
LONGEST_S, OURS_S = 78.0, 52.0
"""Longest of the constant feeds; of the controllers."""


class Account(NamedTuple):
    """One way to turn a bar; means over noise seeds."""

    time_s: float
    """From the start of the feed to the end of the bar."""
    rate: float
    """Mean removal rate, mm^3/s."""
    peak_n: float
    """Largest true force."""
    over_s: float
    """Time above 110 % of 150 N."""
    feed_same_peak: float = 0.0
    """Constant feed with this peak, mm/min."""
    time_same_peak_s: float = 0.0
    """What it takes."""

    @property
    def gain(self) -> float:
        """Time of the constant feed of equal peak over this one's."""
        return self.time_same_peak_s / self.time_s


class Bar(NamedTuple):
    """A bar, turned in all ways."""

    accounts: dict[str, Account]
    """By controller, and of the constant feed with a peak of 150 N."""
    feeds: list[Account]
    """Of :data:`FEEDS`."""
    along: dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]]
    """Way in mm, true force and feed of the first run, by fuzzy controller."""


def changes_of(bar: str) -> dict[str, Any]:
    """Changes that put a bar on the lathe; the tool at 1 mm."""
    work = stretches([STRETCH_MM * i for i in range(4)], [b - 1.0 for b in DEPTHS[bar]], HARDER[bar])
    known = {f"{place}.work.{key}": value for place in ("controller.removal", "plant") for key, value in work.items()}
    return known | {"plant.work.ends": LENGTH_MM, "plant.limit": LIMIT_N}


@measure
def lathe_of_ours(lab: Lab) -> Loop:
    """The whole lathe with our controller of the force; its program made, to be shared by both bars."""
    loop = whole_lathe(three_loops(FORCE[OURS]))
    loop.batch(PERIOD_S, {}, runs=1, record=RECORD)
    return loop


@measure
def turned(lab: Lab, bar: str) -> Bar:
    """The fuzzy controllers, the fixed removal rate and the constant feeds in one batch; ours in another."""
    rows: list[dict[str, Any]] = [force_law(name) for name in FUZZY for _ in range(SEEDS)]
    rows += [force_law("corrected.tfc_stfc") | {"controller.removal.rate": FIXED_RATE} for _ in range(SEEDS)]
    rows += [force_law("corrected.tfc_stfc") | constant_feed(feed) for feed in FEEDS]
    rest = {"controller.removal.rate": 0.0, "controller.feed.lower": 0.0, "controller.feed.upper": 1.0}
    keys = {key: np.array([(rest | row)[key] for row in rows]) for key in rest | rows[0]}
    run = running(lab).using(changes_of(bar)).batch(LONGEST_S, keys, record=RECORD)
    own = lathe_of_ours(lab).using(changes_of(bar)).batch(OURS_S, {}, runs=SEEDS, record=RECORD)
    found = {n: counted(run, slice(i * SEEDS, (i + 1) * SEEDS)) for i, n in enumerate((*FUZZY, REGULATED))}
    found[OURS] = counted(own, slice(0, SEEDS))
    first = SEEDS * (len(FUZZY) + 1)
    feeds = [counted(run, slice(first + i, first + i + 1)) for i in range(len(FEEDS))]
    along = {}
    for i, name in enumerate(FUZZY):
        way = run["actual.travel"][i * SEEDS]
        part = way < LENGTH_MM
        along[name] = (way[part], run["actual.force"][i * SEEDS][part], run["actual.feed"][i * SEEDS][part])
    accounts = {name: _beside(account, feeds) for name, account in found.items()}
    return Bar(accounts | {"constant feed": steady(feeds, FORCE_N)}, feeds, along)


def _beside(account: Account, feeds: list[Account]) -> Account:
    same = steady(feeds, account.peak_n)
    return account._replace(feed_same_peak=same.feed_same_peak, time_same_peak_s=same.time_s)


def steady(feeds: list[Account], peak: float) -> Account:
    """The constant feed with a peak, between those that were tried; the largest, where its peak is less."""
    peaks = np.log([a.peak_n for a in feeds])
    at = float(np.interp(math.log(peak), peaks, np.arange(len(feeds))))

    def between(values: list[float]) -> float:
        return float(np.exp(np.interp(at, np.arange(len(feeds)), np.log(values))))

    time_s, feed = between([a.time_s for a in feeds]), between(list(FEEDS))
    rate = between([a.rate for a in feeds])
    over = 0.0 if peak <= LIMIT_N else float(np.interp(at, np.arange(len(feeds)), [a.over_s for a in feeds]))
    return Account(time_s, rate, peak if at < len(feeds) - 1 else feeds[-1].peak_n, over, feed, time_s)


def counted(run: Any, rows: slice) -> Account:
    """The account of some rows of a batch, up to the end of the bar; means."""
    travel = run["actual.travel"][rows]
    times, values = [], []
    for i, way in enumerate(travel):
        k = int(np.searchsorted(way, LENGTH_MM))
        if k >= len(way):
            raise RuntimeError(f"the bar is not done after {run.time[-1]:g} s: {way[-1]:.1f} of {LENGTH_MM:g} mm")
        share = (LENGTH_MM - way[k - 1]) / (way[k] - way[k - 1])
        times.append(run.time[k - 1] + share * (run.time[k] - run.time[k - 1]))
        values.append([run[f"plant.{key}"][rows][i, k] for key in ("removed", "peak", "over_s")])
    removed, peak, over = np.mean(values, axis=0)
    time_s = float(np.mean(times))
    return Account(time_s, float(removed) / time_s, float(peak), float(over))
