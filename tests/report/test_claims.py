"""When a claim is met, at the very limit and beyond, and how its target reads."""

import math

import pytest

from leadscrew.report import tables
from leadscrew.report.claim import Claim


def claim(measured=1.0, sense="<=", target=2.0, tolerance=0.25, kind="required"):
    return Claim(
        "a.b", "Table 1", "as printed", "arithmetic", "It is so.", 1.0, measured, "mm", sense, target, tolerance, kind,
        "reproduced",
    )  # fmt: skip


@pytest.mark.parametrize(
    ("sense", "met", "missed"),
    [
        ("<=", (-9.0, 2.25), (2.2500001,)),
        (">=", (1.75, 9.0), (1.7499999,)),
        ("=", (1.75, 2.25), (1.7499999, 2.2500001)),
    ],
)
def test_a_claim_is_met_up_to_its_tolerance_and_not_beyond(sense, met, missed):
    assert [claim(x, sense).passed for x in met] == [True] * len(met)
    assert [claim(x, sense).passed for x in (*missed, math.nan, None)] == [False] * (len(missed) + 2)


def test_a_claim_in_words_is_met_by_the_same_words():
    assert claim("a, b", "order", "a, b").passed and not claim("b, a", "order", "a, b").passed


@pytest.mark.parametrize(
    ("sense", "tolerance", "text"), [("<=", 0.0, "≤ 2"), (">=", 0.0, "≥ 2"), ("=", 0.25, "2 ± 0.25"), ("=", 0.0, "2")]
)
def test_a_target_reads_as_it_is_judged(sense, tolerance, text):
    assert tables.target(claim(sense=sense, tolerance=tolerance)) == text


def test_only_a_required_target_that_is_not_met_counts_as_missed():
    bad, met = claim(9.0), claim(1.0)
    aimed, reported, without = claim(9.0, kind="moonshot"), claim(9.0, kind="report"), claim(9.0, target=None)
    everything = [bad, met, aimed, reported, without]
    assert tables.missed(everything) == [bad]
    assert [tables.met(c) for c in everything] == ["NO", "yes", "NO", "–", "–"]
    assert tables.tally(everything)[1:] == (3, 2)
