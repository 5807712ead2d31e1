"""Claims of a study in few words: what is the same in most of them is said once."""

from __future__ import annotations

from leadscrew.report.claim import Basis, Claim, Group, Kind, Sense, Verdict


def claim_of(
    study: str,
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
    """The claim ``study.name``; without a number of the paper it gives no verdict on it."""
    value = measured if isinstance(measured, str) else float(measured)
    return Claim(
        f"{study}.{name}", source, group, basis, statement, paper, value, unit, sense, target, tolerance, kind,
        verdict, reason,
    )  # fmt: skip


def verdict_of(holds: bool, change: bool = False) -> Verdict:
    """The verdict on a statement of the paper that holds here, under a change of ours or without, or does not."""
    return ("reproduced with change" if change else "reproduced") if holds else "not reproduced"


def word(holds: bool) -> str:
    """``yes`` or ``no``."""
    return "yes" if holds else "no"
