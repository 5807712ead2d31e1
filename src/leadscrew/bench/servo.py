"""Rows of one loop: single runs against C, batches, a settled loop against a moving one."""

from __future__ import annotations

import time
from functools import partial
from typing import Any

import numpy as np

from leadscrew.bench import entries, loops
from leadscrew.bench.row import row
from leadscrew.bench.timing import interleaved, load, repeated
from leadscrew.bench.yardstick import NoCompilerError, Yardstick, same_bits

MOVING, SCENARIO = 800, 4000
"""Periods until the axis stands within a count, and of the whole scenario."""
INTEGRATORS = {"hold": "exact zero-order hold", "rk4": f"RK4, {loops.SUBSTEPS} substeps"}
Rows = list[dict[str, Any]]


def yardstick(loop: Any) -> tuple[Yardstick | None, str]:
    """The C loops, or why there are none."""
    try:
        return Yardstick(loop), ""
    except NoCompilerError as why:
        return None, str(why)


def single_rows(form: str, rounds: int, errors: dict[str, float]) -> Rows:
    """One run of ours against the C loops, while the axis moves and over the whole scenario."""
    loop = loops.lathe(form)
    c, why = yardstick(loop)
    integrator, error = INTEGRATORS[form], errors.get(form)
    rows: Rows = []
    for what, periods, repeats in (("first 0.8 s, moving", MOVING, 40), ("whole scenario, 4 s", SCENARIO, 8)):
        ours = entries.single(loop, periods)
        contenders = {"ours": repeated(ours, repeats)}
        for library in ("portable", "libm"):
            if c is None:
                continue
            name = f"{form}_{library}"
            contenders[library] = repeated(partial(c.run, name, periods), repeats)
        ns = {k: v / periods / repeats * 1e9 for k, v in interleaved(contenders, rounds).items()}
        name = f"single run, {form}"
        rows.append(row(name, f"ours, {what}", ns["ours"], integrator=integrator, error=error))
        for library, bound in (("portable", 1.10), ("libm", 1.5)):
            title = f"against C with {'the same portable functions' if library == 'portable' else 'libm'}, {what}"
            if c is None:
                rows.append(row(name, title, integrator=integrator, remark=f"left out: {why}"))
                continue
            same = same_bits(c.run(f"{form}_{library}", periods), ours())
            remark = f"C {ns[library]:.0f} ns; {'same bits' if same else 'other bits'}"
            if library == "portable" and not same:
                remark += " - they should be the same"
            rows.append(
                row(name, title, ns["ours"], ratio=ns["ours"] / ns[library], at_most=bound, integrator=integrator,
                    error=error, remark=remark)
            )  # fmt: skip
    return rows


def batch_rows(rounds: int, quick: bool) -> Rows:
    """Batches in lanes: per core against C, two threads against one, runs a second."""
    loop = loops.lathe()
    c, why = yardstick(loop)
    runs = 128 if quick else 512
    gains = {"plant.full_duty_speed_mm_s": np.linspace(259.0, 334.0, runs)}
    lanes = entries.batch(loop, MOVING, gains)
    contenders = {"lanes": lanes}
    if c is not None:
        contenders["portable"] = repeated(partial(c.run, "hold_portable", MOVING), runs)
        contenders["libm"] = repeated(partial(c.run, "hold_libm", MOVING), runs)
    ns = {k: v / runs / MOVING * 1e9 for k, v in interleaved(contenders, rounds).items()}
    rows = [row("batch, one core", "ours in lanes", ns["lanes"], integrator=INTEGRATORS["hold"])]
    for library in ("portable", "libm"):
        what = f"against scalar C with {'the same portable functions' if library == 'portable' else 'libm'}"
        if c is None:
            rows.append(row("batch, one core", what, remark=f"left out: {why}"))
            continue
        rows.append(
            row("batch, one core", what, ns["lanes"], ratio=ns[library] / ns["lanes"], at_least=2.3,
                integrator=INTEGRATORS["hold"], remark=f"C {ns[library]:.0f} ns; the ratio is C over ours")
        )  # fmt: skip
    many = {"plant.full_duty_speed_mm_s": np.linspace(259.0, 334.0, 2000 if quick else 10_000)}
    both = {k: entries.batch(loop, 200, many, threads=k) for k in (1, 2)}
    walls = interleaved({str(k): v for k, v in both.items()}, rounds, time.perf_counter)
    n = len(many["plant.full_duty_speed_mm_s"])
    for k in (1, 2):
        rows.append(row(f"batch, {k} thread{'s' * (k > 1)}", f"{n} runs of 200 periods", n / walls[str(k)], "runs/s"))
    remark = f"wall time against one thread; for an idle machine, load now {load():.2f}"
    rows.append(
        row("batch, 2 threads", "against one thread", n / walls["2"], "runs/s", ratio=walls["1"] / walls["2"],
            at_least=1.7, remark=remark)
    )  # fmt: skip
    return rows


def settled_rows(rounds: int) -> Rows:
    """A settled loop, whose states have decayed to nothing, against a moving one."""
    rows = []
    for form in INTEGRATORS:
        loop = loops.lathe(form)
        rested = loop.start()
        rested.advance(60_000, every=0)
        calls = {"moving": entries.single(loop, MOVING), "settled": entries.single(loop, MOVING, rested)}
        seen = interleaved({k: repeated(call, 20) for k, call in calls.items()}, rounds)
        ns = {k: v / MOVING / 20 * 1e9 for k, v in seen.items()}
        rows.append(
            row(f"settled loop, {form}", "against the moving one", ns["settled"], ratio=ns["settled"] / ns["moving"],
                at_most=1.1, integrator=INTEGRATORS[form], remark=f"moving {ns['moving']:.0f} ns; no denormal slowdown")
        )  # fmt: skip
    return rows
