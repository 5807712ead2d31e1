"""All claims of the study: arithmetic, data, moves."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from leadscrew.report.claim import Claim
from leadscrew.studies.vud_lathe.claims_arithmetic import arithmetic_claims
from leadscrew.studies.vud_lathe.claims_data import data_claims
from leadscrew.studies.vud_lathe.claims_motion import motion_claims
from leadscrew.studies.vud_lathe.tables import Move


def all_claims(runs: Mapping[str, Any], sweep: Any, moves: Mapping[str, Move]) -> list[Claim]:
    """Every claim, judged."""
    return [*arithmetic_claims(), *data_claims(moves), *motion_claims(runs, sweep, moves)]
