"""``leadscrew certify``: what it prints and saves, what it proves, and the sentences with which it refuses."""

import json
from functools import cache

import numpy as np
import pytest
from typer.testing import CliRunner

from leadscrew.cli import app
from tests.cli.conftest import strict_json

STUDY = "npid_xytable"
FILE = "examples/xy_table_npid.py:loop"


QUICK = ("--no-simulate",)


@cache
def certified(controller, *args, code=0):
    asked = ["certify", STUDY, "-c", controller, *QUICK, "--json", *map(str, args)]
    result = CliRunner().invoke(app, asked)
    assert result.exit_code == code, result.output
    return strict_json(result.stdout)


def test_the_slope_limited_law_is_certified_under_every_load_by_a_verified_inequality(call):
    text = call("certify", STUDY, "-c", "npid_slope", "--no-simulate").stdout
    assert "CERTIFIED: npid_slope is stable under every command and load, by a verified matrix inequality." in text
    assert "order 6; from the steps that are exported" in text and "up to 2.265 of 2.2 asked" in text
    assert "Popov" not in text, "it proves nothing of the sampled loop, so it is opt-in"


def test_popov_is_added_on_request_and_does_not_count(call):
    text = call("certify", STUDY, "-c", "npid_slope", "--no-simulate", "--popov").stdout
    assert "does not count" in text and "Popov is a criterion for continuous loops" in text


@pytest.mark.slow
def test_the_papers_law_is_not_and_the_reason_is_its_slope(call):
    said = call("certify", STUDY, "-c", "corrected.npid_um", "--no-simulate", code=1).stdout
    assert "slope [1, 5.546]" in said and "it counts the error in um" in said
    assert "npid is stable at rest (proved), but not proved under every command and load" in said
    assert "its slope reaches 5.546, above the Nyquist limit of 2.51: under load it chatters." in said
    assert "describing function, a prediction" in said and "192.6 Hz" in said


def test_saved_it_can_be_checked_by_anybody_with_numpy(call, tmp_path):
    out = tmp_path / "certificate.json"
    printed = certified("npid_slope", "-o", out)
    saved = json.loads(out.read_text())
    assert printed.pop("out") == str(out) and printed.pop("plot") is None and printed == saved
    assert saved["certified"] and saved["grade"] == "certificate" and saved["map"]["slope_sector"] == [1.0, 2.2]
    a, b, c = (np.array(saved["loop"][k]) for k in "abc")
    p, (low, high) = np.array(saved["driven"]["p"]), saved["map"]["slope_sector"]
    assert np.linalg.eigvalsh(p).min() > 0.0
    # x+ = a x + b w, e = -c x, (w - low e)(high e - w) >= 0: x' P x falls by more than what the sector adds
    z = np.hstack([a, b])
    e, w = np.hstack([-c, [[0.0]]]), np.hstack([np.zeros_like(c), [[1.0]]])
    sector = (w - low * e).T @ (high * e - w)
    held = np.zeros((len(a) + 1,) * 2)
    held[: len(a), : len(a)] = p
    fall = z.T @ p @ z - held
    left = fall + sector + sector.T
    scale = 1.0 / np.sqrt(np.abs(np.diag(left)))
    assert np.linalg.eigvalsh(scale[:, None] * left * scale).max() < -1e-9


@pytest.mark.parametrize(("name", "code"), [("paper.pid", 0), ("ours.pid_scaled", 0), ("ours.pid_ms_159", 0)])
def test_a_linear_controller_has_its_margins_and_a_stable_loop(call, name, code):
    found = certified(name, code=code)
    assert not found["map"]["nonlinear"] and found["stable"] and found["autonomous"] == []
    if name == "paper.pid":
        numbers = found["margins"]["numbers"]
        assert numbers["gm"] == pytest.approx(2.510, abs=1e-3) and numbers["ms"] == pytest.approx(1.87, abs=5e-3)


def test_an_unstable_loop_is_refused_in_a_sentence(call):
    found = certified("corrected.npid_um", "--set", "controller.kd=0.03", code=1)
    assert found["verdict"] == "NOT CERTIFIED: the linear loop of npid is unstable."
    assert "has to be stabilised before any sector" in found["autonomous"][0]["statement"]


def test_a_sector_beyond_the_nyquist_limit_is_refused_in_a_sentence(call):
    found = certified("npid_slope", "--set", "controller.k=2.6", "--level", "autonomous", code=1)
    assert "reaches beyond the Nyquist limit: with a constant gain of 2.51" in found["autonomous"][0]["statement"]


@pytest.mark.slow
def test_a_grid_that_is_too_coarse_is_refused_in_a_sentence(call):
    found = certified("npid_slope", "--points", 12)
    circle = found["autonomous"][0]
    assert found["margins"]["numbers"]["gm"] == pytest.approx(2.51, abs=0.001), "margins keep the loop's own grid"
    assert any("too coarse" in w for w in found["warnings"])
    assert circle["grade"] == "refused" and "The grid of 12 frequencies is too coarse" in circle["statement"]
    assert found["driven"]["grade"] == "certificate", "a matrix inequality needs no grid"
    assert certified("npid_slope", "--points", 400)["autonomous"][0]["grade"] == "grid-checked"


@pytest.mark.slow
def test_an_error_in_mm_is_warned_of(call):
    said = call("certify", STUDY, "-c", "paper.npid_mm", "--duration", 2, code=1).stdout
    assert "K(e) never gets near its bound of 2.352 here" in said and "Was um meant?" in said
    assert "error of 3 mm" in said


@pytest.mark.slow
def test_the_levels_and_a_reserve_decide_what_counts():
    steep = "--set", "controller.k=2.29"
    assert not certified("npid_slope", *steep, code=1)["certified"]
    rest = certified("npid_slope", *steep, "--level", "autonomous")
    assert rest["certified"] and "at rest, without command and load" in rest["verdict"]
    assert "limit of 2.265 is 1.03 times its bound" in certified("npid_slope", "--reserve", 1.1, code=1)["verdict"]
    assert certified("npid_slope", "--set", "controller.k=2", "--reserve", 1.1)["certified"]


def test_a_linear_controller_is_certified_at_either_level(call):
    found = certified("paper.pid", "--level", "autonomous", "--proof", "--reserve", 2)
    assert found["certified"] and found["grade"] == "certificate" and found["driven"]["limit"] > 2.0
    found = certified("ours.pid_scaled", "--level", "autonomous", "--reserve", 1.5, code=1)
    limit, margin = found["driven"]["limit"], found["margins"]["numbers"]["gm"]
    assert f"with a reserve of 1.5 times: the limit of {limit:.4g} is {limit:.4g} times" in found["verdict"]
    assert 1.0 < limit < margin == pytest.approx(2.51 / 2.265, abs=1e-3)


@pytest.mark.slow
def test_a_reserve_that_is_missed_at_rest_is_one_of_the_gain_and_names_who_proves_most():
    found = certified("corrected.npid_um", "--level", "autonomous", "--reserve", 1.05, code=1)
    most = max(found["autonomous"], key=lambda c: c["limit"] or 0.0)
    share = most["limit"] / found["map"]["sector"][1]
    assert most["criterion"] == "Zames-Falb" and 1.0 < share < 1.05
    said = f"the limit of {most['limit']:.4g} is {share:.4g} times its bound of 2.352, by Zames-Falb."
    assert said in found["verdict"]


def test_no_criterion_reaches_further_than_zames_falb_and_a_limit_beyond_the_slope_is_one_of_both():
    found = certified("npid_slope")
    limits = {c["criterion"]: c["limit"] for c in found["autonomous"] if "inequality" not in c["criterion"]}
    others = [limits[k] for k in ("circle", "Tsypkin", "Jury-Lee")]
    assert found["map"]["slope_sector"][1] < max(others) <= limits["Zames-Falb"] * (1.0 + 1e-5)
    assert limits["Zames-Falb"] <= found["nyquist_limit"] == pytest.approx(2.51, abs=1e-3)


LEVITATED = '''
from typing import NamedTuple

from leadscrew import Loop, controller, plant
from leadscrew.references._step import step


class AxisParams(NamedTuple):
    pull: float = 400.0


class AxisState(NamedTuple):
    position: float = 0.0
    speed: float = 0.0


@plant(AxisParams(), AxisState(), output="position", unit="mm")
def levitated(p, s, u):
    """A slide on a magnet that pulls it the further away, the further it is."""
    return AxisState(s.speed, p.pull * s.position + 1000.0 * u)


class HoldParams(NamedTuple):
    kp: float = 4.0
    kd: float = 0.1
    max_output: float = 1.0


class HoldState(NamedTuple):
    last: float = 0.0


@controller(HoldParams(), HoldState(), unit="V")
def hold(p, s, command, feedback, dt):
    e = command - feedback
    u = p.kp * e + p.kd * (e - s.last) / dt
    limited = min(max(u, -p.max_output), p.max_output)
    return HoldState(e), limited if p.max_output > 0.0 else u


loop = Loop(reference=step(target=5.0), controller=hold, plant=levitated, period=5e-4, substeps=4, metrics={})
'''


def test_a_scenario_that_diverges_is_not_certified_whatever_is_proved(call, tmp_path):
    """The pull of the magnet at 5 mm, 2 V, is more than the drive has: worked by hand, 400 * 5 / 1000."""
    (tmp_path / "levitated.py").write_text(LEVITATED, encoding="utf-8")
    subject = f"{tmp_path / 'levitated.py'}:loop"
    options = ("--duration", 1, "--json")
    ran = strict_json(call("certify", subject, *options, code=1).stdout)
    assert ran["driven"]["grade"] == "certificate" and not ran["certified"] and ran["grade"] == "refused"
    assert "the scenario diverged: the error ran away to" in ran["verdict"] and "what is proved" in ran["verdict"]
    held = strict_json(call("certify", subject, *options, "--set", "controller.max_output=0").stdout)
    near = strict_json(call("certify", subject, *options, "--set", "reference.target=0.05").stdout)
    assert held["certified"] and near["certified"] and near["run"]["diverged"] is None


def test_the_gain_behind_the_pid_has_no_driven_criterion(call):
    found = certified("npid_after", code=1)
    assert found["driven"] is None and "stands behind" in found["verdict"]
    assert [c["criterion"] for c in found["autonomous"]] == ["circle", "circle, matrix inequality"]


@pytest.mark.slow
def test_undamped_resonators_do_not_stop_it():
    found = certified("ours.resonant")
    assert found["certified"] and found["grade"] == "certificate"


@pytest.mark.slow
def test_two_paths_are_one_map_beside_a_linear_loop():
    found = certified("npid_split")
    assert found["map"]["slope_sector"] == [0.0, 1.0] and found["driven"]["grade"] == "certificate"
    from leadscrew.studies.npid_xytable.split_law import SPLIT, around_large

    loop = around_large(SPLIT)
    w = np.geomspace(1.0, 6e3, 200)
    a, b, c = (np.array(found["loop"][k]) for k in "abc")
    points = np.exp(1j * w * 5e-4)
    mine = [(c @ np.linalg.solve(z * np.eye(len(a)) - a, b))[0, 0] for z in points]
    assert np.abs(mine - loop.response(w)).max() < 1e-9 * np.abs(loop.response(w)).max()
    assert found["driven"]["limit"] > 3.0


@pytest.mark.slow
def test_at_rest_the_papers_gain_is_proved_by_zames_falb_where_the_other_criteria_fall_short():
    rest = certified("corrected.npid_um", "--level", "autonomous", "--proof")
    assert rest["certified"] and rest["grade"] == "certificate"
    grades = {c["criterion"]: c["grade"] for c in rest["autonomous"]}
    assert grades["Zames-Falb, matrix inequality"] == "certificate" and grades["Zames-Falb"] == "grid-checked"
    assert {grades[name] for name in ("circle", "Tsypkin", "Jury-Lee", "Tsypkin, matrix inequality")} == {"refused"}


@pytest.mark.slow
def test_a_loop_in_a_file_of_ones_own_is_certified_too(call):
    found = strict_json(call("certify", FILE, "--json", code=1).stdout)
    assert found["run"] is None and found["map"]["sector"] == pytest.approx([1.0, 2.35241], abs=1e-5)


@pytest.mark.slow
def test_the_hash_is_that_of_the_export(call, tmp_path):
    folder = tmp_path / "machine"
    call("export", FILE, "--target", "c99", "--duration", 0.1, "--out", folder)
    manifest = json.loads((folder / "manifest.json").read_text())
    whose = strict_json(call("certify", FILE, "--json", code=1).stdout)["controller"]
    assert whose["source_hash"] == manifest["source_hash"]
    # JSON has no infinity: a limit that there is not is null in the one and 1e308 in the other, as in the C.
    parameters = {k: None if v in (1e308, -1e308) else v for k, v in manifest["parameters"].items()}
    assert whose["parameters"] == parameters
    other = strict_json(call("certify", FILE, "--json", "--set", "controller.alpha=0.4", code=1).stdout)["controller"]
    assert other["source_hash"] == whose["source_hash"] and other["fingerprint"] != whose["fingerprint"]


@pytest.mark.slow
def test_the_plot_is_drawn(call, tmp_path):
    for name, code in (("npid_slope", 0), ("paper.pid", 0), ("npid_after", 1)):
        out = tmp_path / f"{name}.png"
        call("certify", STUDY, "-c", name, "--no-simulate", "--plot", out, code=code)
        assert out.stat().st_size > 10_000


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (["-c", "tfc"], "no map of the error is declared for it"),
        (["-c", "npid_slope", "--level", "both"], "there are autonomous, driven"),
        (["-c", "npid_slope", "--reserve", "0.5"], "a reserve is a factor from 1 on"),
        (["-c", "npid_slope", "--points", "2"], "a grid has at least 3"),
        (["-c", "npid_slope", "-o", "certificate.txt"], "a certificate ends in .json"),
        (["-c", "npid_slope", "--plot", "certificate.bmp"], ".png, .svg, .pdf"),
        (["-c", "npid_slop"], "npid_slope"),
        (["-c", "paper.pid", "-s", "sine_1mm_on_friction_low"], "not linear"),
        (["-c", "ours.repetitive"], "at most 100 can be certified"),
        (["-c", "ours.resonant_adaptive"], "no map of the error is declared"),
        (["-c", "ours.pid_td"], "no map of the error is declared"),
        (["-c", "ours.learned"], "schedules on the command or adapts to it"),
        (["-c", "ours.learned", "--level", "autonomous"], "schedules on the command or adapts to it"),
    ],
)
def test_what_cannot_be_is_refused_with_exit_code_2(refused, args, said):
    assert said in refused("certify", STUDY, "--no-simulate", *args)


@pytest.mark.slow
def test_a_clipped_error_is_refused_for_its_lower_bound_of_zero(call):
    found = certified("corrected.npid_um_clipped", code=1)
    assert found["map"]["sector"][0] == 0.0 and found["driven"]["grade"] == "refused"
    assert any("lower bound of the sector is 0" in w for w in found["warnings"])
