"""Claims of this study in few words: what is the same in most of them is said once."""

from __future__ import annotations

from leadscrew.report.claim import Basis, Claim, Group, Kind, Sense, Verdict


def said(
    name: str,
    source: str,
    statement: str,
    measured: float | str,
    unit: str,
    target: float | str | None,
    reason: str,
    *,
    tolerance: float = 0.0,
    sense: Sense = "=",
    kind: Kind = "required",
    group: Group = "ours",
    basis: Basis = "reconstructed plant",
    paper: float | str | None = None,
    verdict: Verdict = "cannot be checked",
) -> Claim:
    """A claim of ``grey_turning``; without a number of the paper it gives no verdict on it."""
    value = measured if isinstance(measured, str) else float(measured)
    return Claim(
        f"grey_turning.{name}", source, group, basis, statement, paper, value, unit, sense, target, tolerance, kind,
        verdict, reason,
    )  # fmt: skip


def word(holds: bool) -> str:
    """``yes`` or ``no``."""
    return "yes" if holds else "no"
