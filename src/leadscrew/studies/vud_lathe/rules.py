"""From Table 1 to Table 2: the rules that the data gives, and the completion that gives the rest."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

import numpy as np

from leadscrew.controllers.vud.universe import CENTRES, TABLE_2
from leadscrew.fuzzy.completion import Completion, complete_rules
from leadscrew.fuzzy.learning import LearnedRules, learn_rules
from leadscrew.fuzzy.partition import Partition
from leadscrew.studies.vud_lathe.tables import Move

LABELS = ("NB", "NM", "NS", "PS", "PM", "PB")
SETS = Partition(tuple(CENTRES.tolist()), LABELS)
"""The six sets of e, ec and the duty (Figures 6 to 8)."""

MAGNITUDES = (0.333, 0.677, 1.0)
"""Sizes of small, medium and big in Table 2; the text and the sets have 0.33 and 0.67."""

Rate = Literal["signed", "printed"]


def samples(found: Mapping[str, Move], rate: Rate = "signed") -> list[tuple[float, float, float]]:
    """The samples k = 1 ... 20 of all moves: the paper's 80."""
    return [
        (float(e), float(ec), float(rho))
        for move in found.values()
        for e, ec, rho in zip(
            move.error[1:], (move.rate if rate == "signed" else move.printed_rate)[1:], move.duty[1:], strict=True
        )
    ]


def learn(found: Mapping[str, Move], ties: Literal["drop", "keep"] = "drop", rate: Rate = "signed") -> LearnedRules:
    """The rules of Table 1 by (12) to (16) and the choice of the strongest."""
    return learn_rules(samples(found, rate), (SETS, SETS), SETS, ties, names=("e", "ec", "rho"))


def rebuild(learned: LearnedRules, add_growth_level: bool = True) -> Completion:
    """The full table; see :mod:`leadscrew.fuzzy.completion` for what is data in it and what is not."""
    return complete_rules(learned, add_growth_level)


def equal_cells(completion: Completion, table: np.ndarray = TABLE_2) -> int:
    """How many cells of the rebuilt table equal Table 2."""
    return completion.agreement(table, MAGNITUDES)
