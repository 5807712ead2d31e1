"""What must be known to read the numbers of a Monte Carlo, a sentence each; only what holds for this one."""

from __future__ import annotations

from typing import TYPE_CHECKING

from leadscrew.tune.sensitivity import UNKNOWN

if TYPE_CHECKING:
    from leadscrew.tune.montecarlo import MonteCarlo
    from leadscrew.tune.montecarlo_report import Findings

EVEN = {"lhs": "a Latin hypercube is", "sobol": "Sobol points are"}
"""Samplings whose runs are not independent."""


def alike(found: MonteCarlo) -> str:
    """Says that all runs are the same run; nothing where they are not."""
    if not found.alike:
        return ""
    return (
        f"all {len(found)} runs are the same run, bit for bit: nothing is drawn and no noise reaches a metric, so "
        "there are no intervals; name what varies with --over"
    )


def independence(found: MonteCarlo) -> str:
    """On what the intervals rest; nothing where they rest on what was done."""
    if found.alike or not len(found.space) or found.method not in EVEN:
        return ""
    return (
        f"intervals are derived for independent runs; {EVEN[found.method]} more even than that, so they are as a rule "
        "too wide (--sampling random: independent runs)"
    )


def unknown(findings: Findings) -> str:
    """Which Sobol indices the runs do not tell; nothing where all are known."""
    rows = [s for s in findings.sobol if not (s.first_known and s.total_known)]
    if not rows:
        return ""
    names = ", ".join(dict.fromkeys(s.metric for s in rows))
    return (
        f"Sobol indices that are not known ({names}): their bootstrap interval is wider than ± {UNKNOWN:g}, as after a "
        f"few runs far from all others; take a larger N than {findings.points}"
    )


def missing(findings: Findings) -> str:
    """Which metrics have no Sobol indices because runs gave no value."""
    lost = {s.metric: s.without for s in findings.sobol if s.without}
    said = ", ".join(f"{metric} ({count})" for metric, count in lost.items())
    return f"no Sobol indices where runs gave no value: {said}" if lost else ""


def without_value(found: MonteCarlo) -> list[str]:
    """Why runs give no value of a metric, a sentence each; the reason is that of the first such run."""
    several = len(found.samples.scenarios) > 1
    return [
        f"{w.metric}{f' in {w.scenario}' if several else ''} has no value in {w.runs} of {len(found)} runs; "
        f"run {w.first}: {w.reason}"
        for w in found.without_value
    ]


def notes(findings: Findings) -> list[str]:
    """All of them."""
    said = (alike(findings.found), independence(findings.found), unknown(findings), missing(findings))
    return [s for s in said if s] + without_value(findings.found)
