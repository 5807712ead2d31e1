"""A verdict follows from the numbers beside it: none can stay behind when a number moves."""

import re

import pytest

from leadscrew.catalogue import study
from leadscrew.studies.vud_lathe.claims_motion import NEAR_MM
from tests.studies.contract import (
    assert_items_exist,
    assert_no_verdict_without_a_paper,
    assert_required_met_and_explained,
)
from tests.studies.whole import together, whole

pytestmark = together("vud_lathe")
LATHE = study("vud_lathe")


@pytest.fixture(scope="module")
def result():
    return whole(LATHE.name)


BY_READING = {
    "eq10_full": "the printed number under another reading of (10)",
    "eq10_intervals": "the printed number under another reading of (10)",
    "eq6_kec": "cut off, not rounded",
    "example_alpha_ec": "rounded up",
    "example_ec_pb": "the paper's number follows from its rounded alpha, as the reason shows",
    "ec_scale_m190": "what the rows give for 25.87 mm per 0.1 s; the change is the unit",
    "ec_scale_m50": "what the rows give for 25.87 mm per 0.1 s; the change is the unit",
    "ec_scale_p50": "what the rows give for 25.87 mm per 0.1 s; the change is the unit",
    "ec_scale_p190": "what the rows give for 25.87 mm per 0.1 s; the change is the unit",
    "ec_largest": "a universe's end, not a rounded number",
    "ec_mismatch_m50": "against what rounding to three digits explains",
    "ec_mismatch_p50": "against what rounding to three digits explains",
    "ec_mismatch_p190": "against what rounding to three digits explains",
    "arrival_table1": "almost reached, read as within 10 mm",
    "count_error": "a grade in words",
    "motor_resistance": "follows from two pairs of the paper's numbers",
    "motor_torque_constant": "follows from two pairs of the paper's numbers",
    "order_vud_m50": "the original is first indeed, but by seconds and not by a little",
    "order_vud_m170": "the original is first indeed, but by seconds and not by a little",
}


def agrees(claim) -> bool:
    """Whether what we measured is what the paper says, at the precision at which it says it."""
    if isinstance(claim.paper, str) or isinstance(claim.measured, str):
        return str(claim.paper).startswith(str(claim.measured))
    bound = claim.sense == "<=" or claim.source == "Figure 12" or re.search("_(2um|error)_", claim.id)
    if bound:
        return claim.measured is not None and claim.measured <= claim.paper
    decimals = len(repr(float(claim.paper)).partition(".")[2]) if claim.paper != int(claim.paper) else 0
    return abs(claim.measured - claim.paper) < 0.51 * 10.0**-decimals


def test_verdicts_agree_with_the_numbers(result):
    wrong = []
    for claim in result.claims:
        name = claim.id.removeprefix("vud_lathe.")
        if claim.paper is None or claim.verdict == "cannot be checked":
            continue
        said_so = claim.verdict.startswith("reproduced")
        if "mm away at" in claim.reason:
            near = float(re.search(r"([\d.]+) mm away at", claim.reason)[1]) <= NEAR_MM
            if near != said_so:
                wrong.append((name, claim.reason, claim.verdict))
        elif agrees(claim) != said_so and name not in BY_READING:
            wrong.append((name, claim.paper, claim.measured, claim.sense, claim.verdict))
    assert not wrong, "\n".join(map(str, wrong))


def test_findings_carry_the_measured_numbers(result):
    text = " ".join(result.notes)
    creep = next(c.measured for c in result.claims if c.id == "vud_lathe.printed_creep")
    assert f"{creep:.2f} mm/s" in text
    pd = result.runs["fig11a_step_m50/ours.pd"].metrics["settling_2um"]
    assert f"{pd:.2f}" in text and "Rules in conflict" in text


def test_every_required_claim_of_the_whole_study_is_met_and_says_why(result):
    assert_required_met_and_explained(result)


def test_the_moonshots_of_the_digest_are_met(result):
    moonshots = {c.id.removeprefix("vud_lathe."): c.passed for c in result.claims if c.kind == "moonshot"}
    names = ("opt_2um", "robust_2um", "robust_error", "robust_overshoot", "friction_error")
    wanted = {f"{name}_{move}" for name in names for move in ("m50", "m170")}
    assert wanted <= set(moonshots) and all(moonshots.values())


def test_a_claim_without_a_number_in_the_paper_gives_no_verdict_on_it(result):
    assert_no_verdict_without_a_paper(result)


def test_pictures_have_names_of_their_own(result):
    names = [p.name for p in result.pictures]
    assert len(names) == len(set(names)) and {"two_by_two", "contraction", "iso_230_2", "creep"} <= set(names)


def test_items_of_the_paper_point_at_claims_and_pictures_that_exist(result):
    assert_items_exist(LATHE, result)
