"""The why of fuzzy controllers: shares times values are what the controller did, for every family."""

import math
import re

import numpy as np
import pytest

from leadscrew import resolve
from leadscrew.controllers._force.gain_normalised import gain_normalised
from leadscrew.controllers._grey_fuzzy import gpfc, smith, tfc
from leadscrew.controllers._guard.feed_override import feed_override
from leadscrew.controllers._guard.force_guard import force_guard
from leadscrew.controllers._input_dob import input_dob
from leadscrew.controllers._sofnn.network import sofnn_all_weights
from leadscrew.controllers._vud.family import vud_family
from leadscrew.controllers._vud.scaled import vud_scaled
from leadscrew.kernel.parameters import entries
from leadscrew.operate.why import explained, explainer
from leadscrew.references._cut_line import TangentCommand
from leadscrew.references._cutting_program import CutCommand
from leadscrew.sensors._cut_camera import SeenCut
from leadscrew.sensors._load_cell import CutReading
from leadscrew.studies.npid_xytable.tunings import XY_TABLE
from leadscrew.studies.sofnn_tangent.tunings import CURVATURE
from leadscrew.studies.sofnn_tangent.tunings import TUNINGS as SOFNN
from tests.operate.plain import check_shares, periods, said, value_of

STUDIES = ("vud_lathe", "grey_turning", "fsmc_ballscrew", "sofnn_tangent", "npid_xytable")
RNG = np.random.default_rng(12)
WALK = np.cumsum(RNG.normal(size=400))
NOISE = RNG.normal(size=400)


NETWORKS = ("corrected.fnn", "corrected.sofc", "paper.sofnn_pnn", "ours.sofnn_nlms")
"""One of each kind; the others take longer."""


def clip(x: float, most: float) -> float:
    return min(most, max(-most, x))


def slide(k: int) -> tuple[float, float]:
    """A slide on its way to -50 mm, in counts of 0.625 um; it passes the target."""
    return -50.0, 6.25e-4 * round((-55.0 * (1.0 - math.exp(-k / 25.0)) + 0.02 * WALK[k]) / 6.25e-4)


def force(k: int) -> tuple[float, float]:
    return 150.0, 150.0 - 120.0 * math.exp(-k / 20.0) + 2.0 * WALK[k]


def seen_cut(k: int) -> tuple[TangentCommand, SeenCut]:
    """A cut that is lost from sight for a while."""
    command = TangentCommand(0.0, 0.3 * k, 0.02 * math.sin(k / 30.0), 0.3 * k, 0.05 * math.sin(k / 20.0), float(k))
    return command, SeenCut(3.0 * WALK[k] + NOISE[k], 0.0 if 40 <= k < 50 else 1.0)


def vud_blocks() -> dict:
    found = resolve.study("vud_lathe").controllers
    return {n: b for n, b in found.items() if "rules" in getattr(b.params, "_fields", ())}


@pytest.mark.parametrize("name", sorted(vud_blocks()))
def test_the_shares_of_a_variable_universe_controller_give_its_duty(name: str) -> None:
    block = vud_blocks()[name]
    for at in periods(block, slide, 0.005, 50):
        check_shares(at.views)
        p, fuzzy = block.params, said(at.views)
        assert fuzzy == pytest.approx(value_of(at.views, "rules"), abs=1e-12)
        duty = value_of(at.views, "duty")
        if block.name == "vud_incremental":
            assert duty == pytest.approx(clip(at.before.rho + p.gain * fuzzy, 1.0), abs=1e-12)
        elif block.name == "vud_scaled":
            assert duty == pytest.approx(clip(p.output_gain * fuzzy + at.after.integral, 1.0), abs=1e-12)
        elif block.name == "vud_fast":
            speed = p.speed_limit_mm_s / (at.plan.chain.speed * at.after.chain.gain)
            asked = p.output_gain * fuzzy
            limit = p.brake_limit if asked * at.before.chain.slow < 0.0 else 1.0
            assert duty == pytest.approx(clip(asked, min(limit, speed)), abs=1e-12)
        else:
            most = getattr(p, "output_limit", 2.0 if block.name == "vud" else 1.0)
            assert duty == pytest.approx(clip(value_of(at.views, "beta") * fuzzy, most), abs=1e-12)
        assert duty == pytest.approx(at.output, abs=0.0)


def test_the_universe_contracts_on_the_way_to_the_target() -> None:
    widths = []
    for at in periods(vud_blocks()["paper.vud"], slide, 0.001, 120):
        error = at.views["sets"]["inputs"][0]
        widths.append(error["high"] - error["low"])
        assert error["full_high"] == 190.0
        assert error["value"] == pytest.approx(at.command - at.feedback)
        expected = (1.0 if not at.before.started else abs(error["value"] / 190.0) ** 0.9 + 1e-4) * 190.0
        assert error["high"] == pytest.approx(expected)
        assert error["sets"][-1]["points"][-1][0] >= error["high"] * (1.0 - 1e-12)
    assert min(widths) < 0.1 * widths[1]


def test_a_reversed_or_ignored_rate_is_shown_as_the_rules_see_it() -> None:
    for gain in (-0.5, 0.0):
        for at in periods(vud_family(rate_gain=gain), slide, 0.001, 40):
            check_shares(at.views)
        rate = at.views["rules"]["inputs"][1]
        assert rate["unit"] == ("" if gain == 0.0 else "mm/s")


@pytest.mark.parametrize("inference", [0, 1])
@pytest.mark.parametrize("block", [tfc, gpfc, gpfc(reading=1, predictor=8), smith], ids=lambda b: b.name)
def test_the_shares_of_a_force_controller_give_the_step_of_its_output(block, inference: int) -> None:
    block = block(inference=inference, output_scale=0.001)
    for at in periods(block, force, 0.02, 120):
        check_shares(at.views)
        step = said(at.views)
        assert at.output == pytest.approx(min(max(at.before.output + step, 0.0), 1.0), abs=1e-14)
        strengths = [r["strength"] for r in at.views["rules"]["rules"]]
        total = math.fsum(strengths)
        assert [r["share"] for r in at.views["rules"]["rules"]] == pytest.approx([x / total for x in strengths])
        assert (total == pytest.approx(1.0)) if inference == 0 else 1.0 - 1e-12 <= total <= 2.0 + 1e-12


def test_the_rules_of_a_grey_controller_are_asked_about_the_predicted_error() -> None:
    for at in periods(gpfc, force, 0.02, 40):
        error = at.views["rules"]["inputs"][0]
        assert error["name"] == "predicted error"
        assert error["value"] == pytest.approx(at.command - value_of(at.views, "predicted force"))
    assert error["value"] != pytest.approx(at.command - at.feedback, abs=1e-3)


def test_a_rule_reads_as_a_sentence_with_the_studys_own_names() -> None:
    texts = set()
    for block, signals in ((tfc, force), (vud_scaled, slide)):
        for at in periods(block, signals, 0.001, 60):
            texts |= {r["text"] for r in at.views["rules"]["rules"]}
    assert "if error is PB and change is ZO then the output changes by PB" in texts
    assert "if error is NB and change is PS then duty is PB" in texts
    assert all(re.fullmatch(r"if .+ is [NPZ][BMSO] and .+ is [NPZ][BMSO] then .+ [NPZ][BMSO]", t) for t in texts)


def test_a_controller_inside_others_is_found_with_its_own_state() -> None:
    def cut(k: int) -> tuple[CutCommand, CutReading]:
        return CutCommand(150.0, 1.0, 1.0, 100.0), CutReading(force(k)[1], force(k)[1], 0.03 * k, 0.4 * k)

    for wrapped, signals, dt in (
        (gain_normalised(tfc(output_scale=0.001)), force, 0.02),
        (force_guard(tfc(output_scale=0.001)), cut, 0.02),
        (feed_override(force_guard(tfc(output_scale=0.001))), cut, 0.02),
        (input_dob(vud_scaled, model=XY_TABLE), slide, 0.5e-3),
    ):
        for at in periods(wrapped, signals, dt, 50):
            check_shares(at.views)
            inner = at.views["rules"]["inputs"][0]["value"]
            assert inner == pytest.approx(190.0 * at.after.e if hasattr(at.after, "e") else at.after.error)
    # Normalised: what the rules say, scaled by the output.
    for at in periods(gain_normalised(tfc(output_scale=0.001)), force, 0.02, 80):
        asked = min(max(at.before.output + said(at.views), 0.0), 1.0) - at.before.output
        expected = at.before.output + (at.before.output / 0.2367 + 0.3) * asked
        assert at.output == pytest.approx(min(max(expected, 0.0), 1.0), abs=1e-14)


@pytest.mark.parametrize(
    "name",
    [n if n in NETWORKS else pytest.param(n, marks=pytest.mark.slow) for n in sorted(SOFNN)],
)
def test_the_shares_of_a_network_give_its_level_and_its_offset(name: str) -> None:
    block = SOFNN[name]
    for at in periods(block, seen_cut, 0.01, 100):
        check_shares(at.views)
        level = clip(said(at.views), 6.0)
        assert level == pytest.approx(value_of(at.views, "level"), abs=1e-12)
        if hasattr(at.after, "past_d"):
            assert level == pytest.approx(at.after.past_d[at.before.at], abs=1e-12)
        wanted = clip(clip(block.params.k_d * level, block.params.max_offset) - at.after.short, block.params.max_offset)
        note = at.views["rules"]["note"]
        assert bool(note) == (at.feedback.seen < 0.5)
        if not note:
            assert at.output == pytest.approx(wanted, abs=1e-12)


def test_what_a_network_has_learned_is_told_from_what_it_began_with() -> None:
    block = SOFNN["paper.sofnn_rounded"]
    first = last = None
    for at in periods(block, seen_cut, 0.01, 100):
        first, last = first or at, at
    assert first is not None and last is not None
    assert value_of(first.views, "learned of it") == pytest.approx(0.0, abs=1e-12)
    learned = [r["value"] - r["prior"] for r in last.views["rules"]["rules"]]
    assert max(map(abs, learned)) > 0.1
    for rule in last.views["rules"]["rules"]:
        assert rule["value"] == pytest.approx(last.after.weights[rule["number"] - 1])
        assert rule["prior"] == pytest.approx(block.params.prior[rule["number"] - 1])
        assert f"at first {rule['prior']:+.2f}" in rule["text"]


def test_learned_memberships_and_certainties_count_in_the_shares() -> None:
    block = sofnn_all_weights(q_centre=0.02, q_certainty=0.05)
    for at in periods(block, seen_cut, 0.01, 60):
        check_shares(at.views)
        assert clip(said(at.views), 6.0) == pytest.approx(at.after.past_d[at.before.at], abs=1e-12)
    peaks = [s["points"][1][0] for s in at.views["sets"]["inputs"][0]["sets"][1:-1]]
    assert np.max(np.abs(np.array(peaks) - 15.0 * at.after.centres_e[1:-1])) < 1e-9
    assert np.max(np.abs(np.array(peaks) - [-60.0, -30.0, 0.0, 30.0, 60.0])) > 0.1


@pytest.mark.parametrize("name", ["ours.curvature_network", "ours.curvature_rules"])
def test_the_rules_of_the_curvature_and_the_rest_give_the_offset(name: str) -> None:
    p = CURVATURE[name].params
    for at in periods(CURVATURE[name], seen_cut, 0.01, 120):
        check_shares(at.views)
        parts = [value_of(at.views, n) for n in ("level", "by the direction", "by the observer")]
        assert parts[0] == pytest.approx(said(at.views), abs=1e-12)
        assert at.output == pytest.approx(clip(p.k_d * sum(parts), p.max_offset), abs=1e-9)
        assert at.views["rules"]["inputs"][0]["value"] == pytest.approx(at.command.curvature_ahead)


@pytest.mark.parametrize("study", STUDIES)
def test_no_fuzzy_and_no_sliding_controller_is_left_without_its_why(study: str) -> None:
    for name, block in resolve.study(study).controllers.items():
        tables = {e.key.rsplit(".", 1)[-1]: np.size(e.default) for e in entries(block.params)}
        fuzzy = "rules" in tables or "terms" in tables or tables.get("prior", 0) >= 49
        sliding = re.search(r"smc|twisting", name) is not None
        found = explained(block)
        views = set(found[1].views) if found else set()
        assert ({"rules", "sets"} <= views) == fuzzy, name
        assert ("phase" in views) == sliding, name


def test_a_controller_without_a_view_says_why() -> None:
    study = resolve.study("npid_xytable")
    found = explainer(study.loop("paper.pid", "quiet"), "paper.pid")
    assert found.views == ()
    assert found.reason.startswith("paper.pid is neither a fuzzy nor a sliding-mode controller")
