"""What ``leadscrew montecarlo`` prints."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import typer

from leadscrew.cli.output import print_table
from leadscrew.report.tables import NOTHING, number
from leadscrew.tune.montecarlo_notes import missing, unknown, without_value
from leadscrew.tune.worst import DIVERGED

if TYPE_CHECKING:
    from leadscrew.tune.montecarlo_report import Findings
    from leadscrew.tune.statistics import Yield

SHOWN = (1, 5, 50, 95, 99)


def print_findings(findings: Findings, out: Path) -> None:
    """The tables, the commands that run the worst again, where the report is, how fast it went."""
    found = findings.found
    several = len(found.samples.scenarios) > 1
    columns = ["metric", *(["scenario"] if several else []), *(f"{p} %" for p in SHOWN), "unit", "without"]
    rows = []
    for s in found.spreads:
        at = {q.percent: number(q.value) for q in s.quantiles}
        where = [s.scenario] if several else []
        rows.append(
            [s.metric, *where, *(at[p] for p in SHOWN), findings.unit(s.metric), str(s.diverged + s.without or "")]
        )
    print_table(columns, rows, right=[*(f"{p} %" for p in SHOWN), "without"])
    for note in without_value(found):
        typer.echo(f"\n{note}")
    rows = [[text, *_yield(y)] for text, y in found.yields.items()]
    rows.append(["all together" if rows else "did not diverge", *_yield(found.joint)])
    typer.echo("")
    print_table(["tolerance", "passed", "yield", "95 % interval"], rows, right=("passed", "yield"))
    _failures(findings)
    _sensitivities(findings, several)
    _life(findings)
    if findings.worst:
        typer.echo("\nThe worst runs, to run again:")
        for w in findings.worst:
            what = f"{w.of} at {number(w.value)} s" if w.of == DIVERGED else f"{w.of} {number(w.value)}"
            typer.echo(f"  {findings.replay(w, out)}   # run {w.run}, {what}")
    cost = findings.cost
    lost = int(found.diverged.sum())
    memory = "" if cost["peak_memory_mib"] is None else f", {cost['peak_memory_mib']:.0f} MiB at most"
    typer.echo(
        f"\n{cost['runs']} runs in {cost['seconds']:.2f} s, {cost['runs_per_s']:,.0f} runs/s on {cost['crew']}{memory}"
        f"; {lost} diverged\n{out / 'report.html'}"
    )


def _yield(found: Yield) -> list[str]:
    part = [f"{100.0 * x:.4g} %" for x in (found.value, found.low, found.high)]
    ends = f"{part[1]} to {part[2]}" if found.low == found.low else NOTHING
    return [f"{found.passed} of {found.runs}", part[0], ends]


def _failures(findings: Findings) -> None:
    rows = [
        [f.tolerance, f.key, f"{f.larger:.3f}", f"{f.larger_low:.3f} to {f.larger_high:.3f}",
         f"{f.low:.4g} to {f.high:.4g}", f"{f.failed} of {f.inside} fail"]
        for f in findings.found.failures
    ]  # fmt: skip
    if rows:
        typer.echo("")
        columns = ["which runs fail", "parameter", "larger in failed", "95 % interval", "all failures within", "there"]
        print_table(columns, rows, right=("larger in failed",))


def _sensitivities(findings: Findings, several: bool) -> None:
    where = ["scenario"] if several else []
    rows = [
        [c.metric, *([c.scenario] if several else []), c.key, f"{c.value:.3f}", f"{c.low:.3f} to {c.high:.3f}",
         number(round(c.partial, 3))]
        for c in findings.found.correlations
        if c.value == c.value
    ]  # fmt: skip
    if rows:
        typer.echo("")
        columns = ["metric", *where, "parameter", "rank correlation", "95 % interval", "partial"]
        print_table(columns, rows, right=("rank correlation", "partial"))
    rows = [
        [s.metric, *([s.scenario] if several else []), s.key,
         f"{s.first:.3f} ± {s.first_width:.3f}" if s.first_known else "not known",
         f"{s.total:.3f} ± {s.total_width:.3f}" if s.total_known else "not known"]
        for s in findings.sobol
        if s.first == s.first
    ]  # fmt: skip
    if rows:
        typer.echo("")
        print_table(["metric", *where, "parameter", "Sobol, first order", "total"], rows)
    for note in (unknown(findings), missing(findings)):
        if note:
            typer.echo(f"\n{note}")


def _life(findings: Findings) -> None:
    life, end = findings.envelope, findings.crossing
    if life is None or end is None:
        return
    typer.echo("")
    rows = [[f"{at:.3g}", *_yield(y)] for at, y in zip(life.life, life.yields, strict=True)]
    print_table(["life", "passed", "yield", "95 % interval"], rows, right=("life", "passed", "yield"))
    level = f"{100.0 * end.level:g} %"
    if end.life != end.life:
        typer.echo(f"the yield does not fall below {level} within this life")
    else:
        late = "beyond this life" if end.high != end.high else number(end.high)
        span = "" if end.low != end.low else f" (95 %: {number(end.low)} to {late})"
        typer.echo(f"the yield falls below {level} at {number(end.life)} of the life{span}")
