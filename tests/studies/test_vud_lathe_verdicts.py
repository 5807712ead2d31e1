"""A verdict follows from the numbers beside it: none can stay behind when a number moves."""

import pytest

from leadscrew.catalogue import study
from leadscrew.studies.vud_lathe.claims_motion import NEAR_MM


@pytest.fixture(scope="module")
def result():
    return study("vud_lathe").evaluate(lambda what, done: None)


BY_READING = {
    "eq10_full": "the printed number under another reading of (10)",
    "eq10_intervals": "the printed number under another reading of (10)",
    "eq6_kec": "cut off, not rounded",
    "example_alpha_ec": "rounded up",
    "example_ec_pb": "the paper's number follows from its rounded alpha, as the reason shows",
    "order_vud_m50": "the original is first indeed, but by seconds and not by a little",
    "order_vud_m170": "the original is first indeed, but by seconds and not by a little",
}


def agrees(claim) -> bool:
    """Whether what we measured is what the paper says, at the precision at which it says it."""
    if isinstance(claim.paper, str) or isinstance(claim.measured, str):
        return str(claim.paper).startswith(str(claim.measured))
    if claim.sense == "<=" or claim.source == "Figure 12":
        return claim.measured <= claim.paper
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
            near = float(claim.reason.split(" mm away")[0]) <= NEAR_MM
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
