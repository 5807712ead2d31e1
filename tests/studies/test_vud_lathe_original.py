"""The original servo: what Table 1 says of plant and law, against hand sums, NumPy and the plain Python loop."""

import contextlib
import io

import numpy as np
import pytest

from leadscrew.controllers.vud.power_law import power_law
from leadscrew.plants.lathe_servo import lathe_servo
from leadscrew.sensors.encoder_count import encoder_count
from leadscrew.studies.vud_lathe import original
from leadscrew.studies.vud_lathe.claims_original import best_exponent, original_claims, static_gain_fit
from leadscrew.studies.vud_lathe.figures_original import original_pictures
from leadscrew.studies.vud_lathe.original import EXPONENT, GAIN, SPEED
from leadscrew.studies.vud_lathe.runs import Loops
from leadscrew.studies.vud_lathe.tables import moves
from tests.docs.snippets import ROOT, assert_printed, with_marks
from tests.studies.plain_loop import run_plain

MOVES = moves()
TIMES = np.arange(21) * 100


@pytest.fixture(scope="module")
def loops():
    return Loops()


@pytest.fixture(scope="module")
def found(loops):
    return original.original_results(loops, MOVES)


@pytest.fixture(scope="module")
def claims(loops, found):
    return {c.id.removeprefix("vud_lathe."): c for c in original_claims(loops, MOVES, found)}


def misfits(speed, gain, exponent):
    """Misfit of a power law from each move in percent of its way, all in plain Python, no compiled loop."""
    parts = []
    for move in MOVES.values():
        run = run_plain(power_law(gain=gain, exponent=exponent), lathe_servo(full_duty_speed_mm_s=speed), encoder_count,
                        move.target_mm, 2001)  # fmt: skip
        e = (move.target_mm - run.signals["feedback"][TIMES]) / 190.0
        parts.append(100.0 * np.sqrt(np.mean((e - move.error) ** 2)) / np.ptp(move.error))
    return np.array(parts)


@pytest.mark.slow
def test_every_required_claim_holds(claims):
    assert {name for name, c in claims.items() if c.kind == "required" and not c.passed} == set()
    assert sum(c.kind == "required" for c in claims.values()) > 50


@pytest.mark.parametrize("law", ["power_289", "p_209"])
def test_the_misfit_is_that_of_a_plain_python_loop_and_no_neighbour_is_better(found, law):
    fit = found.fits[law]
    settings = {SPEED: 289.0, GAIN: 1.0, EXPONENT: 1.0, **original.LAWS[law].fixed, **fit.parameters}
    here = misfits(settings[SPEED], settings[GAIN], settings[EXPONENT])
    assert list(fit.nrmse_percent.values()) == pytest.approx(here, abs=1e-9)
    total = np.sqrt(np.mean(here**2))
    for key in fit.parameters:
        for factor in (0.97, 1.03):
            near = settings | {key: settings[key] * factor}
            assert np.sqrt(np.mean(misfits(near[SPEED], near[GAIN], near[EXPONENT]) ** 2)) > total


def test_the_study_s_stand_in_has_the_constants_of_the_fit(found):
    fit = found.fits["power_289"]
    assert power_law.params.gain == pytest.approx(fit.parameters[GAIN], abs=0.15 * fit.standard_error[GAIN])
    assert power_law.params.exponent == pytest.approx(fit.parameters[EXPONENT], abs=0.15 * fit.standard_error[EXPONENT])


@pytest.mark.slow
@pytest.mark.parametrize("law", list(original.LAWS))
def test_a_search_over_all_the_bounds_finds_nothing_better(loops, found, law):
    """PID and PD may find a flatter corner of their valley, but no lower one."""
    everywhere = original.fit_law(loops, MOVES, law, "global")
    assert everywhere.total_percent == pytest.approx(found.fits[law].total_percent, abs=0.02)


def test_hand_sums_of_table_1_give_the_speeds_without_a_model(claims):
    """Move r = -190: 190 mm over 0.1 s (1.000 + 0.921 + ... + 0.009 = 6.623)."""
    assert claims["travel_over_duty_m190"].measured == pytest.approx(190.0 / 0.6623)
    assert claims["travel_over_duty_m50"].measured == pytest.approx(190.0 * 0.264 / 0.1536)


def test_the_regression_of_the_digest_is_one_of_magnitudes_without_the_start(claims):
    duty, speed = (
        np.concatenate([x[1:-1] for x in (m.duty for m in MOVES.values())]),
        258.7 * np.concatenate([m.rate[2:] for m in MOVES.values()]),
    )
    by_numpy = np.linalg.lstsq(np.abs(duty)[:, None], np.abs(speed), rcond=None)
    assert claims["rate_regression_speed"].measured == pytest.approx(by_numpy[0][0])
    assert claims["rate_regression_r2"].measured == pytest.approx(
        1.0 - by_numpy[1][0] / (len(duty) * np.var(np.abs(speed)))
    )
    assert claims["rate_regression_signed_r2"].measured == pytest.approx(np.corrcoef(duty, speed)[0, 1] ** 2, abs=1e-4)
    assert claims["rate_regression_rest_r2"].measured < claims["rate_regression_r2"].measured


def test_the_exponent_of_the_static_gain_is_a_minimum():
    best = best_exponent(MOVES)

    def total(exponent):
        return sum(m**2 for m in static_gain_fit(MOVES, exponent).nrmse_percent.values())

    assert total(best) < min(total(best - 0.005), total(best + 0.005))


def test_the_static_law_leaves_residuals_that_its_slopes_do_not_see():
    """At a least-squares minimum the residuals are orthogonal to the law's derivatives."""
    fit = original.static_fit(MOVES)
    e, rho = (np.abs(np.concatenate([getattr(m, part)[1:] for m in MOVES.values()])) for part in ("error", "duty"))
    left = fit.gain * e**fit.exponent - rho
    seen = e > 0
    slopes = np.array([e[seen] ** fit.exponent, fit.gain * e[seen] ** fit.exponent * np.log(e[seen])])
    assert np.abs(slopes @ left[seen]) == pytest.approx([0.0, 0.0], abs=1e-5)
    assert fit.rms == pytest.approx(np.sqrt(np.mean(left**2)))


def test_the_linear_laws_creep_where_the_power_law_has_arrived(found):
    for way in original.TARGETS_MM:
        assert found.played["power_289"].within_s(way, 0.010) < 2.0
        for linear in ("p_209", "pid_209"):
            assert found.played[linear].within_s(way, 0.010) > 2.0


def test_the_picture_shows_table_1_and_every_law(found):
    (picture,) = original_pictures(found, MOVES)
    figure = picture.draw()
    labels = {text.get_text() for text in figure.legends[0].get_texts()}
    assert "Table 1" in labels and len(labels) == 5
    shown = figure.axes[0].lines[-1]
    assert shown.get_ydata() == pytest.approx(MOVES["r=-190"].error)
    assert all(axes.get_xlabel() for axes in figure.axes[-2:]) and all(a.get_ylabel() for a in figure.axes[::2])


@pytest.mark.slow
def test_the_page_of_the_docs_shows_what_its_python_prints():
    page = ROOT / "docs" / "original_servo.md"
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        exec(compile(with_marks(page), str(page), "exec"), {"__name__": "page"})
    assert_printed(page, said.getvalue())
