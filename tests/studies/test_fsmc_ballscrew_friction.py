"""The study's claims and pictures of friction and backlash, against the vectors, SciPy and numbers worked by hand."""

import math
from functools import lru_cache

import numpy as np
import pytest

from leadscrew.analysis.friction_runs import break_away, force_at_speed
from leadscrew.friction.lugre import HAT, TABLE_2, TILDE, LuGre
from leadscrew.plants.ballscrew_stage import INERTIA, ballscrew_stage
from leadscrew.plants.mass_lugre import mass_lugre
from leadscrew.studies.fsmc_ballscrew import algebra
from leadscrew.studies.fsmc_ballscrew import backlash_runs as b
from leadscrew.studies.fsmc_ballscrew import friction_experiments as x
from leadscrew.studies.fsmc_ballscrew import impacts as m
from leadscrew.studies.fsmc_ballscrew.claims_backlash import USUAL, backlash_claims
from leadscrew.studies.fsmc_ballscrew.claims_friction import RADAU_RAD, TURNS_URAD, friction_claims, inner_loop
from leadscrew.studies.fsmc_ballscrew.figures_backlash import backlash_pictures
from leadscrew.studies.fsmc_ballscrew.figures_friction import friction_pictures
from leadscrew.studies.fsmc_ballscrew.runs import Loops
from tests.docs.snippets import ROOT
from tests.fuzzy.formats_systems import shared

LOOPS = Loops()


@lru_cache
def claims(topic):
    made = {"friction": friction_claims, "backlash": backlash_claims}[topic](LOOPS)
    return {c.id.removeprefix("fsmc_ballscrew."): c for c in made}


def vector(name):
    return np.loadtxt(shared(f"papers/fsmc_ballscrew_vectors/{name}.csv"), delimiter=",", comments="#")


# ---- claims
@pytest.mark.slow
def test_what_the_paper_says_about_friction_is_judged_by_numbers():
    judged = {
        c.id.removeprefix("fsmc_ballscrew."): c.verdict for c in claims("friction").values() if c.paper is not None
    }
    assert judged["lugre_dwell"] == judged["table2_fc_columns"] == "not reproduced"
    assert judged["lugre_break_away_varies"] == judged["table2_sigma0_tilde"] == "reproduced"
    assert judged["friction_low_speed_slope"] == "not reproduced"


def test_table_2_is_as_printed():
    printed = {
        "plant": (1e5, math.sqrt(1e5), 0.4, 6.24, 9.36, 0.001),
        "hat": (2e5, 2.0 * math.sqrt(1e5), 1.2, 6.24, 9.36, 0.005),
        "tilde": (1e5, math.sqrt(1e5), 1.0, 6.24, 9.36, 0.005),
    }
    assert {name: tuple(f) for name, f in TABLE_2.items()} == {
        name: pytest.approx(numbers) for name, numbers in printed.items()
    }
    assert TABLE_2["hat"] == HAT and TABLE_2["tilde"] == TILDE and TABLE_2["plant"] == LuGre()


# ---- friction
def test_the_open_loop_agrees_with_radau_in_every_row():
    rows = vector("reference_openloop_zoh")
    run = x.held_torque_angle(LOOPS, 0.4)
    assert np.abs(run["plant.angle"] - rows[:, 2]).max() < 1e-9 and len(rows) == 400
    assert {t: rows[round(1e3 * t), 2] for t in RADAU_RAD} == pytest.approx(RADAU_RAD, rel=1e-15)


def test_slow_ramps_before_sliding_agree_with_radau_in_every_row():
    rows = vector("reference_presliding_ramp")
    run = x.experiment(LOOPS, x.STAGE, 50.02, 1e-2, rate=0.8 * 9.36 / 10.0, turn=10.0)
    at = np.rint(rows[:, 0] / 1e-2).astype(int)
    assert np.abs(run["output"][at] - rows[:, 1]).max() < 1e-9
    assert np.abs(run["plant.angle"][at] - rows[:, 2]).max() < 1e-9
    ends = 1e6 * rows[np.searchsorted(rows[:, 0], (10.0, 30.0, 50.0)), 2]
    assert ends == pytest.approx(TURNS_URAD, abs=5e-4)


@pytest.mark.slow
def test_the_studys_experiments_are_those_of_the_analysis():
    """Another loop, another integration in time: held forces and 8000 samples a rise."""
    assert [x.peak_friction(LOOPS, r) for r in (1.0, 20.0)] == pytest.approx(
        break_away(mass_lugre, [1.0, 20.0]), abs=2e-6
    )
    other = force_at_speed(ballscrew_stage, [5.0], x.SLIDES, 9.36)
    assert x.break_away_torque(LOOPS, 5.0) == pytest.approx(other[0], abs=1e-4)
    assert math.isnan(x.break_away_torque(LOOPS, 1.0, highest=6.0))


def test_a_crossing_lies_between_its_samples():
    t = np.linspace(0.0, 1.0, 11)
    assert x.crossing(t, np.exp(3.0 * t), math.exp(1.23)) == pytest.approx(0.41, rel=1e-12)


def test_the_profile_pushes_rests_and_turns():
    p = x.ProfileParams(push=2.0, push_time=1.0, rest=1.0, initial=0.5, rate=3.0, turn=2.0)
    found = [x.profile(p, t) for t in (0.5, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)]
    assert found == pytest.approx([2.0, 0.5, 0.5, 3.5, 6.5, 3.5, 0.5, -5.5, 0.5])


@pytest.mark.slow
def test_lugre_forgets_an_inner_loop_and_maxwell_slip_does_not():
    assert abs(inner_loop(LuGre())[2]) > 1.0
    made = claims("friction")
    assert made["gms_memory"].measured < 1e-9 < made["lugre_memory"].measured


# ---- backlash
def smoothed(radius, rate, restitution, over, step=2e-6):
    """A guide of 20 tanh(v / over) N and the usual damping, semi-implicit steps: gap crossing, and swing after it."""
    k, mass, half = 1e8, 62.4, 1e-6
    zeta = -math.log(restitution) / math.hypot(math.pi, math.log(restitution))
    c = 2.0 * zeta * math.sqrt(k * mass)
    t, turn = -0.04, 0.5 * math.pi / rate
    place, v = radius * math.sin(rate * (t + turn)) - half - 20.0 / k, radius * rate * math.cos(rate * (t + turn))
    classic, crossing, beyond = place, 0.0, []
    while t < 0.06:
        screw = radius * math.sin(rate * (t + turn))
        d, closing = screw - place, radius * rate * math.cos(rate * (t + turn)) - v
        classic = min(max(classic, screw - half), screw + half)
        force = max(k * (d - half) + c * closing, 0.0) if d > half else 0.0
        force += min(k * (d + half) + c * closing, 0.0) if d < -half else 0.0
        crossing = t if crossing == 0.0 and t > 0.0 and d < -half else crossing
        if crossing > 0.0:
            beyond.append(place - classic)
        v += step * (force - 20.0 * math.tanh(v / over) - 50.0 * v) / mass
        place += step * v
        t += step
    return crossing, 1e6 * (max(beyond) - min(beyond))


@pytest.mark.slow
@pytest.mark.parametrize(("name", "digest_ms"), [("sine_wide", 29.2), ("sine_fast", 10.5)])
def test_the_digests_reversal_is_that_of_a_friction_smoothed_over_10_um_s(name, digest_ms):
    radius, rate = m.SINES[name]
    crossing, swing = smoothed(radius, rate, 0.9, 1e-5)
    assert 1e3 * crossing == pytest.approx(digest_ms, abs=0.06)
    assert swing == pytest.approx({"sine_wide": 0.28, "sine_fast": 0.60}[name], abs=0.025)
    sharp = 1e3 * m.impact(LOOPS, name, 0.9).crossing_s
    pressed = 1e3 * m.crossing_of_parabola(name, m.GAP_M + m.pressed_m())
    assert sharp == pytest.approx(pressed, rel=0.006) and sharp > digest_ms


def test_the_digests_soft_impact_is_the_one_of_the_usual_damping():
    """Its p-p of 0.23 um on the fast sine belongs to a restitution of 0.21; with 0.05 it is 0.17 um."""
    usual, asked = m.impact(LOOPS, "sine_fast", USUAL), m.impact(LOOPS, "sine_fast", 0.05)
    assert usual.swing_um == pytest.approx(0.23, abs=0.01) and asked.swing_um == pytest.approx(0.17, abs=0.01)


@pytest.mark.slow
def test_the_least_lag_is_on_the_safe_side_and_not_far_off():
    """A limit cycle below 0.75 of it, none at it; 62.4 kg over the joint's damping at e = 0.9."""
    least = b.least_lag_s()
    zeta = 0.0343
    by_hand = 62.4 / (2.0 * zeta * math.sqrt(1e8 / (1.0 / 62.4 + 1.5923e-3**2 / 2.12e-4)) + 50.0)
    assert least == pytest.approx(by_hand, rel=0.02)
    swings = [b.swing_um(b.backlash_run(LOOPS, "ours.pd_dob", "sine_fast", "two_mass", part * least, 2.25))
              for part in (0.6, 1.0)]  # fmt: skip
    assert swings[0] > 5.0 and swings[1] < 0.1


@pytest.mark.slow
def test_a_loop_that_diverges_says_when():
    found = b.reversed_by(b.backlash_run(LOOPS, "ours.pd_dob", "sine_wide", "play", b.TABLE, 4.0), 1.0)
    assert found.diverged.startswith("diverged at t = 1.5") and math.isnan(found.height_um)


def test_reversals_are_read_as_they_are():
    """Error 0.5 um and after each reversal 2 um for 30 ms, then -0.5 um: height 2, 30 ms, offset 0.5."""

    class Made(dict):
        time = np.arange(0.0, 8.0, 1e-3)
        diverged = None

    t = Made.time
    way = np.where(np.floor((t - 0.5 * math.pi) / math.pi) % 2.0 == 0.0, 1.0, -1.0)
    since = (t - 0.5 * math.pi) % math.pi
    e = np.where(since < 0.03, 2.0 * way, 0.05 * way)
    run = Made({"actual.position": 1e-3 * e, "command.position": np.zeros_like(t)})
    found = b.reversed_by(run, 1.0)
    assert found.height_um == pytest.approx(2.0) and found.offset_um == pytest.approx(0.05)
    assert found.duration_s == pytest.approx(0.03, abs=1.1e-3)


@pytest.mark.slow
def test_a_circle_of_a_dead_band_has_the_play_as_its_deviation():
    """Motor encoders with 2 um of play on both axes: G of the digest's dead band is 1.998 um."""
    made = claims("backlash")
    assert made["backlash_circle_g_motor"].measured == pytest.approx(1.998, abs=0.03)
    assert made["backlash_circle_g_table"].measured < 0.5 * made["backlash_circle_g_motor"].measured


@pytest.mark.slow
def test_the_page_shows_what_is_measured():
    made = claims("backlash")
    page = (ROOT / "docs" / "friction.md").read_text(encoding="utf-8").split("<!-- checked: backlash -->")[1]
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in page.splitlines() if line.startswith("| ")]
    tags = {("table", "ours.fsmc_4khz"): "fsmc", ("table", "ours.pd_dob_fixed"): "pd_dob_fixed",
            ("both, 1 ms", "ours.pd_dob"): "pd_dob_dual"}  # fmt: skip
    assert len(rows) == 9
    for where, who, what, stays, peak, after in rows[1:]:
        key = "fast" if "pi" in what else "wide"
        if where == "motor":
            assert float(stays) == pytest.approx(made[f"backlash_motor_step_{key}"].measured, abs=0.005)
            continue
        tag = f"{tags[where, who]}_{key}"
        assert float(stays) == 0.0 and made[f"backlash_table_step_{key}"].measured < 0.005
        assert float(peak) == pytest.approx(made[f"backlash_peak_{tag}"].measured, abs=0.006)
        lasts = made[f"backlash_duration_{tag}"].measured
        assert lasts == "never" if "never" in after else float(after) == pytest.approx(lasts, abs=0.6)


# ---- pictures
@pytest.mark.slow
def test_every_picture_is_drawn_and_says_its_units(tmp_path):
    pictures = [*friction_pictures(LOOPS), *backlash_pictures(LOOPS)]
    assert len({p.name for p in pictures}) == len(pictures) == 8
    for picture in pictures:
        figure = picture.draw()
        figure.savefig(tmp_path / f"{picture.name}.png", dpi=50)
        for axes in figure.axes:
            if axes.name != "polar":
                assert "(" in axes.get_xlabel() and axes.lines


@pytest.mark.parametrize("inertia", [INERTIA, 1.0])
def test_the_damping_of_a_stuck_stage_is_that_of_its_poles(inertia):
    f = LuGre()
    p, q = np.linalg.eigvals([[-(f.damping + f.viscous) / inertia, -f.stiffness / inertia], [1.0, 0.0]])
    assert algebra.stick_damping(f, inertia) == pytest.approx((-(p + q) / (2.0 * np.sqrt(p * q))).real, rel=1e-6)
