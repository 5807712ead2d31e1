"""A claim of a paper, beside what we measured: the one schema of every study."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any, Literal

SCHEMA_VERSION = 1

Group = Literal["as printed", "as corrected", "ours"]
Basis = Literal["arithmetic", "paper's data", "printed plant", "reconstructed plant", "fitted to this number"]
Sense = Literal["=", "<=", ">=", "order", "yes/no"]
Kind = Literal["required", "moonshot", "report"]
Verdict = Literal["reproduced", "reproduced with change", "not reproduced", "cannot be checked"]


@dataclass(frozen=True)
class Claim:
    """One row: what the paper says, what we measured, what we asked of ourselves.

    ``target`` and ``tolerance`` are ours: with sense ``=`` a claim passes within ``tolerance`` of ``target``, with
    ``<=`` and ``>=`` it passes up to ``target`` (plus or minus ``tolerance``). ``verdict`` is about the paper.
    """

    id: str
    source: str
    group: Group
    basis: Basis
    statement: str
    paper: float | str | None
    measured: float | str | None
    unit: str
    sense: Sense
    target: float | str | None
    tolerance: float
    kind: Kind
    verdict: Verdict
    reason: str = ""

    @property
    def passed(self) -> bool | None:
        """Whether our own target is met; ``None`` where the claim only reports."""
        if self.kind == "report" or self.target is None:
            return None
        if self.sense in ("yes/no", "order") or isinstance(self.target, str) or isinstance(self.measured, str):
            return self.measured == self.target
        if self.measured is None or math.isnan(self.measured):
            return False
        if self.sense == "=":
            return abs(self.measured - self.target) <= self.tolerance
        if self.sense == "<=":
            return self.measured <= self.target + self.tolerance
        return self.measured >= self.target - self.tolerance

    def as_dict(self) -> dict[str, Any]:
        """The claim for JSON, with ``passed`` and ``schema_version``."""
        row = asdict(self)
        row["passed"] = self.passed
        row["schema_version"] = SCHEMA_VERSION
        for key in ("paper", "measured", "target"):
            if isinstance(row[key], float) and not math.isfinite(row[key]):
                row[key] = None
        return row
