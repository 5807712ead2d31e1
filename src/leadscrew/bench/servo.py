"""Rows of one loop: single runs and batches against C, a settled loop against a moving one."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from leadscrew.bench import loops, measuring
from leadscrew.bench.measuring import interleaved, repeated, row
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


def comparisons(moving: bool) -> dict[str, tuple[str, float | None, str]]:
    """Each C loop that a single run is compared with: what it is, our bound, a remark."""
    if moving:
        return {
            "portable": ("C with the same portable functions", None, "judged on the whole scenario"),
            "libm": ("C with libm", 1.5, ""),
        }
    return {
        "portable": ("C with the same portable functions", 1.10, "statement by statement the same"),
        "shortcut": (
            "C that also answers pow(0, y) at once",
            None,
            "no target: a branch that ours, made for lanes, does not have",
        ),
        "libm": (
            "C with libm",
            None,
            "no target here: at rest, three of these 4 s, libm's pow(0, y) returns early; ours does all its work",
        ),
    }


def single_rows(form: str, rounds: int, errors: dict[str, float]) -> Rows:
    """One run of ours against the C loops, while the axis moves and over the whole scenario."""
    loop = loops.lathe(form)
    c, why = yardstick(loop)
    integrator, error = INTEGRATORS[form], errors.get(form)
    name, rows = f"single run, {form}", []
    for what, periods, repeats in (("first 0.8 s, moving", MOVING, 40), ("whole scenario, 4 s", SCENARIO, 8)):
        ours = measuring.single(loop, periods)
        contenders = {"ours": repeated(ours, repeats)}
        compared = comparisons(periods == MOVING)
        if c is not None:
            contenders["engine c"] = repeated(measuring.single(loop, periods, engine="c"), repeats)
            contenders |= {k: repeated(partial(c.run, f"{form}_{k}", periods), repeats) for k in compared}
        ns = {k: v / periods / repeats * 1e9 for k, v in interleaved(contenders, rounds).items()}
        rows.append(row(name, f"ours, {what}", ns["ours"], integrator=integrator, error=error))
        if c is not None:
            rows.append(
                row(f"engine c, {form}", f"against C with the same portable functions, {what}", ns["engine c"],
                    ratio=ns["engine c"] / ns["portable"], at_most=1.10, integrator=integrator, error=error,
                    remark=f"C {ns['portable']:.0f} ns")
            )  # fmt: skip
        for kind, (title, bound, note) in compared.items():
            title = f"against {title}, {what}"
            if c is None:
                rows.append(row(name, title, integrator=integrator, remark=f"left out: {why}"))
                continue
            same = same_bits(c.run(f"{form}_{kind}", periods), ours())
            notes = [f"C {ns[kind]:.0f} ns", "same bits" if same else "other bits", note]
            if kind != "libm" and not same:
                notes.append("THEY SHOULD BE THE SAME")
            rows.append(
                row(name, title, ns["ours"], ratio=ns["ours"] / ns[kind], at_most=bound, integrator=integrator,
                    error=error, remark="; ".join(n for n in notes if n))
            )  # fmt: skip
    return rows


def batch_rows(rounds: int, runs: int, errors: dict[str, float]) -> Rows:
    """A batch in lanes on one core, against the C loop run by run."""
    loop = loops.lathe()
    c, why = yardstick(loop)
    gains = {"plant.full_duty_speed_mm_s": np.linspace(259.0, 334.0, runs)}
    contenders = {"lanes": measuring.batch(loop, MOVING, gains)}
    if c is not None:
        for library in ("portable", "libm"):
            contenders[library] = repeated(partial(c.run, f"hold_{library}", MOVING), runs)
    ns = {k: v / runs / MOVING * 1e9 for k, v in interleaved(contenders, rounds).items()}
    name = "batch, one core"
    facts: dict[str, Any] = {"integrator": INTEGRATORS["hold"], "error": errors.get("hold")}
    rows = [row(name, f"ours in lanes, {runs} runs of 0.8 s, moving", ns["lanes"], **facts)]
    for library in ("portable", "libm"):
        what = f"against scalar C with {'the same portable functions' if library == 'portable' else 'libm'}"
        if c is None:
            rows.append(row(name, what, integrator=INTEGRATORS["hold"], remark=f"left out: {why}"))
            continue
        rows.append(
            row(name, what, ns["lanes"], ratio=ns[library] / ns["lanes"], at_least=2.3,
                remark=f"C {ns[library]:.0f} ns; the ratio is C over ours", **facts)
        )  # fmt: skip
    return rows


def settled_rows(rounds: int, errors: dict[str, float]) -> Rows:
    """A settled loop, whose states have decayed to nothing, against a moving one."""
    rows = []
    for form in INTEGRATORS:
        loop = loops.lathe(form)
        rested = loop.start()
        rested.advance(60_000, every=0)
        calls = {"moving": measuring.single(loop, MOVING), "settled": measuring.single(loop, MOVING, rested)}
        seen = interleaved({k: repeated(call, 20) for k, call in calls.items()}, rounds)
        ns = {k: v / MOVING / 20 * 1e9 for k, v in seen.items()}
        rows.append(
            row(f"settled loop, {form}", "against the moving one", ns["settled"], ratio=ns["settled"] / ns["moving"],
                at_most=1.1, integrator=INTEGRATORS[form], error=errors.get(form),
                remark=f"moving {ns['moving']:.0f} ns")
        )  # fmt: skip
    return rows
