"""The numbers on the page of the inference network are the study's."""

import re
from pathlib import Path

import numpy as np
import pytest

from leadscrew.studies.sofnn_tangent.inference_runs import groups_kept
from tests.studies.whole import claims_of

TEXT = " ".join((Path(__file__).parents[2] / "docs" / "inference_network.md").read_text(encoding="utf-8").split())


@pytest.fixture(scope="module")
def measured():
    return {name: c.measured for name, c in claims_of("sofnn_tangent").items()}


@pytest.mark.slow
@pytest.mark.xdist_group("whole sofnn_tangent")
@pytest.mark.parametrize(
    ("sentence", "claims"),
    [
        (r"copied from the rules \| ([\d.]+) \| ([\d.]+)", ["copied_rules:.3f", "copied_rules_chinese:.3f"]),
        (r"least squares \| ([\d.]+) \| ([\d.]+)", ["least_squares:.4f", "least_squares_chinese:.4f"]),
        (r"one Kalman pass \| ([\d.]+) \| ([\d.]+)", ["least_squares:.4f", "least_squares_chinese:.4f"]),
        (r"the centres too \| ([\d.]+) \| ([\d.]+)", ["trained_centres:.4f", "trained_centres_chinese:.4f"]),
        (r"is worth ([\d.]+) % at best", ["centres_gain:.1f"]),
        (r"the trace is 10\^(\d+)", ["forgetting_trace:.0f"]),
        (r"the twentieth lap is ([\d.]+) times", ["forgetting_laps:.2f"]),
        (r"nothing is gained \((-[\d.]+) %", ["centres_small_walk:.1f"]),
        (r"gains up to (\d+) % in a cell", ["centres_large_walk:.0f"]),
        (r"wanders from -2 to (-[\d.]+) on the wave", ["centres_wander:.1f"]),
        (r"cancels in the mean: (\d+) directions", ["incidence_collapses:.0f"]),
    ],
)
def test_the_page_says_what_the_claims_measure(measured, sentence, claims):
    found = re.search(sentence, TEXT)
    assert found, sentence
    told = [f"{measured[name]:{form}}" for name, form in (c.split(":") for c in claims)]
    assert list(found.groups()) == told


def test_the_page_says_what_all_groups_gain():
    kept = groups_kept()
    base, certain = kept["literal"], kept["literal, certainties 0.01"]
    found = re.search(r"paper's loop from ([\d.]+) to ([\d.]+) deg, and raises it by (\d+) % in one cell", TEXT)
    worst = 100.0 * (certain / base - 1.0).max()
    assert found and found.groups() == (f"{base.mean():.2f}", f"{certain.mean():.2f}", f"{worst:.0f}")
    worse = 100.0 * (kept["tuned, centres 0.01"].mean() / kept["tuned"].mean() - 1.0)
    assert f"The tuned loop gets {np.round(worse):.0f} % worse" in TEXT
    assert f"Tuned scales alone bring {kept['tuned'].mean():.2f} deg" in TEXT
