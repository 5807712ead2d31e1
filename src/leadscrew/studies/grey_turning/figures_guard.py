"""Pictures of the guard: a hard spot with and without it, how soon it acts, and load cells that break."""

from __future__ import annotations

from functools import partial

import numpy as np
from matplotlib.figure import Figure

from leadscrew.report.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION
from leadscrew.sensors.faulty_load_cell import KINDS, faulty_load_cell
from leadscrew.studies.grey_turning import guarding as g
from leadscrew.studies.grey_turning.runs import Loops, build
from leadscrew.studies.grey_turning.scenarios import SCENARIOS
from leadscrew.studies.study import Picture

LEVELS = g.FAST.params.levels
FROM_S, TO_S = 2.2, 3.4


def guard_pictures(loops: Loops) -> list[Picture]:
    """All of them."""
    return [
        Picture("guard_hard_spot", "A hard spot that doubles the force within 40 ms and stays 0.2 s, on plant F: no "
                "guard, and a guard that looks at the raw force every 20 ms or every millisecond. Above, the true "
                "force with the raw readings that the guard of 20 ms sees, at its slowest of twenty phases; below, "
                "voltage and feed. Shaded: that guard holds the feed.", partial(hard_spot_picture, loops)),
        Picture("guard_latency", "From the raw force's crossing of 180 N to the hold, 0 V at the drive, for spots of "
                "1.3 to 3 times the force at random times in noise of 0.5 to 5 N; right, the peak that is left.",
                partial(latency, loops)),
        Picture("guard_broken_cell", "A load cell that breaks at 1.5 s in a steady cut, under guard: what it shows, "
                "and the feed. Dashed: without guard, the same fault.", partial(broken_cell, loops)),
    ]  # fmt: skip


def hard_spot_picture(loops: Loops) -> Figure:
    """Force, voltage and feed through one spot."""
    spots = g.doubling(loops)
    late = spots.held() - spots.crossed()
    worst = int(np.argmax(late[spots.of(g.CASES[0])]))
    slow, fast, free = (int(spots.of(case)[worst]) for case in (g.CASES[0], g.CASES[1], g.CASES[4]))
    run, time = spots.run, spots.run.time
    part = (time >= FROM_S) & (time <= TO_S)
    t = time[part]
    figure = Figure(figsize=(8.2, 6.2), layout="constrained")
    force, volts, feed = figure.subplots(3, 1, sharex=True, height_ratios=(2.2, 1.0, 1.0))
    shown = (("no guard", free, BLACK), ("guard, every 20 ms", slow, BLUE),
             ("guard, every 1 ms", fast, VERMILION))  # fmt: skip
    for name, row, colour in shown:
        force.plot(t, run["actual.force"][row, part], color=colour, label=name)
        volts.plot(t, run["output"][row, part], color=colour, drawstyle="steps-post")
        feed.plot(t, run["actual.feed"][row, part], color=colour)
    at = np.flatnonzero(part)[(np.flatnonzero(part) % 20) == 0]
    force.plot(time[at], run["feedback.raw"][slow, at], "o", color=SKY, markersize=3.5, label="raw readings, 20 ms")
    force.axhline(LEVELS.hold_n, color=ORANGE, linestyle="--", linewidth=1.0)
    force.text(FROM_S + 0.01, LEVELS.hold_n + 4.0, "hold_n", color=ORANGE, fontsize="small")
    held = run["controller.guard.mode"][slow, part] > 0
    for axes in (force, volts, feed):
        axes.fill_between(t, 0.0, 1.0, where=held, transform=axes.get_xaxis_transform(), color=BLUE, alpha=0.1)
    crossed = time[spots.crossed()[slow]]
    force.axvline(crossed, color=BLUE, linewidth=0.8, linestyle=":")
    force.annotate(f"crossed; held after {1e3 * (time[spots.held()[slow]] - crossed):.0f} ms", (crossed, 200.0),
                   (crossed - 0.04, 240.0), ha="right", fontsize="small", color=BLUE,
                   arrowprops={"arrowstyle": "-", "color": BLUE})  # fmt: skip
    force.set(ylabel="main cutting force, N", ylim=(0.0, 320.0), xlim=(FROM_S, TO_S))
    volts.set(ylabel="output, V", ylim=(-0.01, 0.3))
    feed.set(ylabel="feed, mm/min", xlabel="time, s", ylim=(-1.0, 45.0))
    force.legend(frameon=False, fontsize="small", loc="upper right")
    return figure


def latency(loops: Loops) -> Figure:
    """Two distributions of the time to the hold; the peak against the size of the spot."""
    spots, drawn = g.drawn(loops)
    figure = Figure(figsize=(8.2, 3.4), layout="constrained")
    times, peaks = figure.subplots(1, 2)
    late = (spots.held() - spots.crossed()).astype(float)
    peak = spots.run["actual.force"].max(axis=1) / g.FORCE_N
    for name, case, colour, mark in (
        ("every 20 ms", g.CASES[0], BLUE, "o"),
        ("every 1 ms", g.CASES[1], VERMILION, "x"),
    ):
        rows = spots.of(case)
        share = np.arange(1, len(rows) + 1) / len(rows)
        times.step(np.sort(late[rows]), 100.0 * share, where="post", color=colour, label=f"looks {name}")
        peaks.plot(1.0 + drawn["disturbance.size"][rows], 100.0 * peak[rows], mark, color=colour, markersize=4)
    grid = np.array([1.3, 3.0])
    peaks.plot(grid, 100.0 * grid, color=BLACK, linewidth=1.0, label="as hard as the spot")
    times.axvline(40.0, color=ORANGE, linestyle="--", linewidth=1.0)
    times.text(41.0, 8.0, "40 ms", color=ORANGE, fontsize="small")
    times.set(xlabel="time to the hold, ms", ylabel="spots held, %", xlim=(-1.0, 60.0), ylim=(0.0, 103.0))
    peaks.set(xlabel="specific force in the spot, times", ylabel="peak force, % of 150 N")
    times.legend(frameon=False, fontsize="small", loc="center right")
    peaks.legend(frameon=False, fontsize="small", loc="upper left")
    return figure


def broken_cell(loops: Loops) -> Figure:
    """What four broken load cells show, and the feed with and without guard."""
    scenario = SCENARIOS["fig6_fixed_depth"]
    kinds = (("constant", 0.0, BLUE), ("error code", 400.0, VERMILION), ("dead", 0.0, GREEN),
             ("wrong scale", 0.5, PURPLE))  # fmt: skip
    changes = {"sensor.fault": [KINDS[k] for k, _, _ in kinds], "sensor.size_n": [n for _, n, _ in kinds]}
    seen = ("feedback.raw", "actual.feed")
    loop = build(g.SLOW_GUARD, scenario, sensor=faulty_load_cell, metrics={})
    run = loop.using({"controller.cell.range_n": 390.0}).batch(3.0, changes, record=seen)
    off = loop.using(g.OFF).batch(3.0, changes, record=seen)
    figure = Figure(figsize=(8.2, 5.0), layout="constrained")
    shown, feed = figure.subplots(2, 1, sharex=True)
    for k, (name, size, colour) in enumerate(kinds):
        label = {"error code": f"stands at {size:g} N", "wrong scale": "half the scale", "dead": "dead: noise about 0"}
        shown.plot(run.time, run["feedback.raw"][k], color=colour, label=label.get(name, name))
        feed.plot(run.time, run["actual.feed"][k], color=colour)
        feed.plot(off.time, off["actual.feed"][k], color=colour, linestyle="--", linewidth=1.0)
    feed.text(2.97, 144.0, "full feed", ha="right", va="top", fontsize="small")
    shown.axvline(1.5, color=BLACK, linewidth=0.8, linestyle=":")
    feed.axvline(1.5, color=BLACK, linewidth=0.8, linestyle=":")
    shown.set(ylabel="raw force shown, N", xlim=(1.2, 3.0), ylim=(-20.0, 430.0))
    feed.set(ylabel="feed, mm/min", xlabel="time, s", ylim=(-3.0, 155.0))
    shown.legend(frameon=False, fontsize="small", ncols=2, loc="center right")
    return figure
