"""The study's circles: claims, what they rest on, and their pictures."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from leadscrew.analysis.circular.diagnosis import diagnose
from leadscrew.analysis.circular.drawn import Circle, draw
from leadscrew.analysis.circular.instrument import BallBar, read_by
from leadscrew.analysis.circular.machine import Machine
from leadscrew.analysis.circular.machine_errors import circle_with
from leadscrew.analysis.circular.paths import CircularTest, Turn
from leadscrew.analysis.circular.quantities import quantities
from leadscrew.bench import circles as bench
from leadscrew.studies.fsmc_ballscrew.circles import CIRCLES, Way, drawn
from leadscrew.studies.fsmc_ballscrew.claims_circle import IDEAL, Circles, both, one, reversals_of
from leadscrew.studies.fsmc_ballscrew.claims_circle_analytic import ALL, circle_analytic_claims, only, share_of_allowed
from leadscrew.studies.fsmc_ballscrew.claims_creep import LAWS, creeps, jumps_um
from leadscrew.studies.fsmc_ballscrew.controllers import CONTROLLERS
from leadscrew.studies.fsmc_ballscrew.figures_circle import circle_pictures
from leadscrew.studies.fsmc_ballscrew.runs import Loops
from tests.studies.whole import claims_of

MM = 1.5923
"""Travel of the table per radian, Table 1."""


@pytest.fixture(scope="module")
def loops():
    return Loops()


def assert_all_hold(claims):
    assert len({c.id for c in claims}) == len(claims)
    for claim in claims:
        assert claim.id.startswith("fsmc_ballscrew.") and claim.statement
        assert (claim.verdict == "cannot be checked") or claim.paper is not None, claim.id
        assert claim.passed is not False or claim.kind == "moonshot", (claim.id, claim.measured, claim.target)
        assert (claim.passed is None) == (claim.kind == "report"), claim.id


@pytest.mark.slow
def test_the_evaluation_s_claims_hold():
    claims = circle_analytic_claims()
    assert_all_hold(claims)
    assert sum("diagnosis" in c.id for c in claims) == 7


@pytest.mark.slow
@pytest.mark.xdist_group("whole fsmc_ballscrew")
def test_which_radius_shrinks():
    verdicts = {name: c.verdict for name, c in claims_of("fsmc_ballscrew").items()}
    # The paper lets the radius shrink under all three.
    assert verdicts["circle_shrinks_fsmc"] == "reproduced" and verdicts["circle_shrinks_smc"] == "not reproduced"


def test_a_diagnosis_of_another_fault_would_not_pass():
    found = diagnose(circle_with(only("backlash"), 100.0, 360))
    share, worst = share_of_allowed(found, only("squareness"))
    assert share > 10.0 and worst == "backlash Y+"
    assert share_of_allowed(found, only("backlash"))[0] < 0.1
    assert only("squareness").squareness_urad == ALL.squareness_urad and only("squareness").x.backlash_plus_um == 0.0


def by_scipy(way, cosine, when):
    """Position, mm, of the stage under conventional sliding mode in continuous time, written down here."""
    inertia, lam, phi, eta = 2.12e-4 + 62.4 * 1.5923e-3**2, 150.0, 0.1, 120.0
    size, w = way.radius_mm / MM, way.rate_rad_s
    ahead = 0.5 * math.pi if cosine else 0.0

    def level(v, v_s):
        return 6.24 + 3.12 * math.exp(-((v / v_s) ** 2))

    def rates(t, s):
        angle, v, z, believed = s
        r, r1 = size * math.sin(w * t + ahead), size * w * math.cos(w * t + ahead)
        r2 = -w * w * r
        z1 = v - abs(v) * 1e5 * z / level(v, 1e-3)
        b1 = r1 - abs(r1) * 2e5 * believed / level(r1, 5e-3)
        friction = 1e5 * z + 316.2 * z1 + 0.4 * v
        hat = 2e5 * believed + 632.5 * b1 + 1.2 * r1
        gain = (level(v, 5e-3) + 1.0 * abs(v)) / inertia + eta
        inside = max(-1.0, min(1.0, (v - r1 + lam * (angle - r)) / phi))
        torque = hat + inertia * (r2 - lam * (v - r1) - gain * inside)
        return [v, (torque - friction) / inertia, z1, b1]

    v = 0.0 if cosine else size * w
    start = [size if cosine else 0.0, v, level(v, 1e-3) / 1e5 * (v > 0.0), level(v, 5e-3) / 2e5 * (v > 0.0)]
    found = solve_ivp(rates, (0.0, when[-1]), start, method="Radau", rtol=1e-8, atol=1e-11, t_eval=when)
    assert found.success
    return MM * found.y[0]


@pytest.mark.slow
def test_a_circle_in_continuous_time_is_that_of_another_solver(loops):
    way = CIRCLES["r1"]
    phi = 2.0 * math.pi * (1.0 + np.arange(1800) / 1800)
    x, y = (by_scipy(way, cosine, phi / way.rate_rad_s) for cosine in (True, False))
    other = quantities(CircularTest(1.0, Turn("ccw", x, y), None)).ccw
    ours = one(drawn(loops, "corrected.smc", way, both=False))
    assert ours.circular == pytest.approx(other.circular, abs=2e-4)
    assert ours.mean_radial == pytest.approx(other.mean_radial, abs=2e-5)


@pytest.mark.slow
@pytest.mark.parametrize(("controller", "within"), [("corrected.smc", 1e-4), ("ours.pd_dob_robust", 0.012)])
def test_clockwise_is_the_mirror_image_but_for_counts_of_the_scale(loops, controller, within):
    found = quantities(drawn(loops, controller, CIRCLES["r1"]))
    assert found.cw.circular == pytest.approx(found.ccw.circular, abs=within)
    mirrored = both(drawn(loops, controller, CIRCLES["r1"], both=False))
    assert found.both.circular == pytest.approx(mirrored.circular, abs=within)


@pytest.mark.slow
def test_a_start_from_rest_draws_the_circle_of_a_start_in_sliding(loops):
    axis = loops.get("ours.smc_4khz", "sine_wide")
    rest = quantities(draw(Machine(axis, axis), Circle(1.0, CIRCLES["r1"].feed_mm_min)))
    sliding = quantities(drawn(loops, "ours.smc_4khz", CIRCLES["r1"], both=False))
    # The start shifts where the counts of the scale fall: one of 10 nm at each end.
    assert rest.ccw.circular == pytest.approx(sliding.ccw.circular, abs=0.02)
    assert rest.both.mean_radial == pytest.approx(sliding.both.mean_radial, abs=0.001)


@pytest.mark.slow
def test_the_report_of_a_circle_says_how_it_was_made(loops):
    test = drawn(loops, "ours.pd_dob", Way(1.0, 2.0 * math.pi), both=False, turns=1.25, period=5e-4)
    assert test.feed_mm_min == pytest.approx(377.0, abs=0.1) and test.start_deg == pytest.approx(90.0)
    assert test.sampling == "1800 points a turn, at 2 kHz; last of 1.25 turns" and test.source == "path"


def test_circles_are_drawn_once(loops):
    circles = Circles(loops)
    assert circles.of("ours.pd_dob", CIRCLES["r1"]) is circles.of("ours.pd_dob", CIRCLES["r1"])


@pytest.mark.slow
def test_a_feed_above_the_threshold_slides_and_one_below_jerks(loops):
    runs = creeps(loops, LAWS["fsmc"], (10.0, 2.0), encoder_nm=0.0)
    above, below = runs[10.0], runs[2.0]
    assert above.peak_to_peak_um < 1e-4 and above.fastest == pytest.approx(1.0, abs=1e-3)
    assert below.peak_to_peak_um > 1.0 and below.fastest > 100.0


def test_jumps_are_placed_by_their_distance_from_the_nearest_axis():
    phi = 2.0 * np.pi * np.arange(1800) / 1800
    radius = 10.0 + 0.001 * (np.degrees(phi) > 280.05)
    where, change = jumps_um(CircularTest(10.0, Turn("ccw", radius * np.cos(phi), radius * np.sin(phi)), None))
    assert np.argmax(change) == 1400 and change.max() == pytest.approx(1.0, abs=1e-6)
    assert where[1400] == pytest.approx(10.0, abs=0.01)


@pytest.mark.slow
def test_every_picture_can_be_drawn_and_has_its_axes_named(loops, tmp_path):
    pictures = circle_pictures(loops)
    assert len({p.name for p in pictures}) == len(pictures) == 8
    for picture in pictures:
        figure = picture.draw()
        figure.savefig(tmp_path / f"{picture.name}.png", dpi=40)
        for axes in figure.axes:
            assert axes.name == "polar" or axes.get_ylabel(), picture.name
        assert figure.legends or picture.name == "fig20_stick_slip"


@pytest.mark.slow
def test_the_bench_draws_both_axes_in_both_directions():
    found = bench.drawn((4000.0,))
    # 100 mm at 4,000 mm/min: a turn takes 9.42 s; 2 axes, 2 directions, 3 controllers, 2 turns and the way to the feed.
    assert found["simulated"] == pytest.approx(3 * 4 * (2 * 9.4248 + 1.178), rel=1e-3)
    assert found["again"] > 0.0
    assert found["first"] > 0.0


@pytest.mark.slow
def test_the_numbers_of_the_ball_bar_page_are_measured(loops):
    page = (Path(__file__).parents[2] / "docs" / "ballbar.md").read_text(encoding="utf-8")
    read = []
    for name in IDEAL:
        test = drawn(loops, name, CIRCLES["r5"], both=False)
        found, glitches = both(test), reversals_of(test)
        tall, last = max(abs(r.height_um) for r in glitches), max(1000.0 * r.duration_s for r in glitches)
        row = f"| `{name}` | {found.circular:.3f} | {found.hysteresis:.3f} | {found.mean_radial:.3f} | {tall:.3f} |"
        assert f"{row} {last:.0f} ms |" in page
        read.append(both(read_by(BallBar(), test)).circular)
    assert "reads {:.2f}, {:.2f} and {:.2f} um".format(*read) in page
    fuzzy, ours = (both(drawn(loops, f"ours.{c}", CIRCLES["r5"], both=False)).circular for c in ("fsmc_4khz", "pd_dob"))
    assert f"draws {fuzzy:.2f} um, the scheduled PD with an observer {ours:.2f} um" in page.replace("\n", " ")
    fast = Way(1.0, 20.0 * math.pi)
    said = page.replace("\n  ", " ")
    for word, change in (("D is {:+.3f} um under `corrected.smc` and {:+.3f} um", {}),
                         ("it is {:.3f} and {:.3f} um", {"hat.viscous": 0.4})):  # fmt: skip
        values = [
            both(drawn(loops, CONTROLLERS[c].using(**change), fast, both=False)).mean_radial
            for c in ("corrected.smc", "corrected.fsmc")
        ]
        assert word.format(*values) in said
