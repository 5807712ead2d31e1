"""The numbers on the page of the ball-screw study are the study's."""

import re
from pathlib import Path

import pytest

from leadscrew.studies.fsmc_ballscrew.runs import Loops, tail_um
from leadscrew.studies.fsmc_ballscrew.scenarios import SINES
from tests.studies.whole import claims_of

PAGE = (Path(__file__).parents[2] / "docs" / "ballscrew.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def loops():
    return Loops()


@pytest.mark.slow
@pytest.mark.xdist_group("whole fsmc_ballscrew")
def test_the_table_of_what_the_paper_says():
    found = {name: c.measured for name, c in claims_of("fsmc_ballscrew").items()}
    assert f"{found['paper_half_sine_wide']:.2f} times on the larger sines" in PAGE
    assert f"{found['paper_half_sine_fast']:.2f}" == f"{found['paper_half_sine_wide']:.2f}"
    assert f"{found['paper_half_sine_slow']:.1f} on the slow one" in PAGE
    assert f"CSMC: {found['paper_step_csmc']:.2f} um that decay" in PAGE
    assert f"{found['paper_rest_fsmc']:.1f} N m stay" in PAGE
    fast, wide, slow = (1e3 * found[f"paper_recovery_sine_{s}"] for s in ("fast", "wide", "slow"))
    assert f"{fast:.0f} and {wide:.0f} ms on the larger sines, {slow:.0f} ms on 0.01 sin t" in PAGE
    assert f"grow by {found['paper_growth_smc']:.2f}" in PAGE and f"{found['paper_growth_csmc']:.2f}" == "1.16"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["ours.fsmc_4khz", "ours.pd_dob"])
def test_the_table_of_largest_errors(loops, name):
    shown = re.search(rf"\| `{re.escape(name)}`[^|]*\| ([\d./ ]+) \|", PAGE)[1].split(" / ")
    assert [f"{tail_um(loops.run(name, s))[0]:.2g}" for s in SINES] == shown


@pytest.mark.slow
@pytest.mark.xdist_group("whole fsmc_ballscrew")
def test_learned_friction_is_as_the_page_says():
    claims = claims_of("fsmc_ballscrew").items()
    found = {name.removeprefix("beaten_"): c.measured for name, c in claims if name.startswith("beaten_")}
    shown = re.search(r"\| `ours.pd_learned`[^|]*\| ([\d./ ]+) \|", PAGE)[1].split(" / ")
    assert [f"{found[f'nominal_{s}']:.2g}" for s in SINES] == shown
    assert max(found["circle_ccw"], found["circle_cw"]) < 0.05
    assert max(found[f"friction_{way}_{s}"] for way in ("p20", "m20") for s in SINES) < 0.1 < found["gms_bound"]
