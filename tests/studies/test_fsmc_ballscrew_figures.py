"""Pictures of learned and of identified friction: what is on them is what the runs say."""

import re

import numpy as np
import pytest

from leadscrew.friction.lugre import LuGre, level
from leadscrew.report.ballbar_picture import CIRCLE, centred
from leadscrew.studies.fsmc_ballscrew.beaten import OURS, Runs
from leadscrew.studies.fsmc_ballscrew.claims_beaten import TURNS
from leadscrew.studies.fsmc_ballscrew.figures_beaten import around, beaten_pictures, learned_over_truth
from leadscrew.studies.fsmc_ballscrew.figures_selftuned import UM_PER_RAD, selftuned_pictures
from leadscrew.studies.fsmc_ballscrew.fits import Fits
from leadscrew.studies.fsmc_ballscrew.runs import PERIOD_S, Loops, tail_um
from tests.docs.snippets import ROOT


@pytest.fixture(scope="module")
def runs():
    return Runs(Loops())


def drawn(pictures, folder):
    figures = {p.name: p.draw() for p in pictures}
    for name, figure in figures.items():
        figure.savefig(folder / f"{name}.png", dpi=40)
        for axes in figure.axes:
            beside = axes.get_shared_y_axes().get_siblings(axes)
            assert axes.name == "polar" or any(a.get_ylabel() for a in beside), name
        assert figure.legends or all(axes.get_legend() for axes in figure.axes), name
    assert all(p.caption for p in pictures)
    return figures


def test_a_picture_is_centred_on_the_worst_reversal_and_seen_from_the_positive_end():
    """A spike 3 ms after the reversal at 3.75 s, at the negative end of sin 2 pi t, in a run of 6 s."""
    error = np.zeros(round(6.0 / PERIOD_S))
    error[round(3.753 / PERIOD_S)] = -2.0
    error[round(0.753 / PERIOD_S)] = -9.0
    t, e = around(error, 1.0)
    assert t[e.argmax()] == pytest.approx(0.003, abs=1e-9) and e.max() == 2.0
    assert t[0] == pytest.approx(-0.5) and t[-1] == pytest.approx(0.5)


@pytest.mark.slow
def test_the_error_on_the_sines_is_the_one_that_the_claims_judge(runs, tmp_path):
    figure = drawn(beaten_pictures(runs.loops, runs)[:1], tmp_path)["learned_sines"]
    for axes, scenario in zip(figure.axes[::2], ("sine_slow", "sine_wide", "sine_fast"), strict=True):
        before, ours = (float(np.abs(line.get_ydata()).max()) for line in axes.lines[:2])
        assert before == pytest.approx(tail_um(runs.loops.run("ours.pd_dob", scenario))[0], rel=1e-9)
        assert ours == pytest.approx(runs.late(OURS, scenario), rel=1e-9)
        assert f"largest {before:.3f} and {ours:.3f}" in axes.get_title("left")


@pytest.mark.slow
def test_learning_is_shown_from_what_is_believed_to_the_truth(runs, tmp_path):
    t, found = learned_over_truth(runs)
    assert [round(float(v[0]), 9) for v in found.values()] == [1.0, 2.0, 2.0, 3.0]
    assert t[-1] > 11.9 and all(abs(float(v[-1]) - 1.0) < 0.1 for v in found.values())
    figure = drawn(beaten_pictures(runs.loops, runs)[1:2], tmp_path)["learned_way"]
    peaks = figure.axes[0].lines[2].get_ydata()
    assert list(peaks) == list(runs.by_reversal(OURS, "sine_fast"))


@pytest.mark.slow
def test_both_circles_have_the_same_magnification_and_their_own_deviations(runs, tmp_path):
    figure = drawn(beaten_pictures(runs.loops, runs)[2:], tmp_path)["learned_circle"]
    titles = [axes.get_title() for axes in figure.axes]
    assert titles[0].startswith("ours.pd_dob") and titles[1].startswith("ours.pd_learned")
    scale = [re.findall(r"([\d.]+) µm a division", title)[0] for title in titles]
    assert scale[0] == scale[1] and len({axes.get_ylim() for axes in figure.axes}) == 1
    shown = [np.ptp(axes.lines[1].get_ydata()) * float(scale[0]) for axes in figure.axes]
    deviations = centred(runs.circle(OURS, TURNS))["ccw"][1]
    assert shown[1] == pytest.approx(float(np.ptp(deviations)), rel=1e-9) and shown[0] > 1.3 * shown[1]
    assert np.all(figure.axes[0].lines[0].get_ydata() == CIRCLE)


@pytest.mark.slow
def test_the_record_and_the_fit_are_shown_beside_the_truth(tmp_path):
    loops = Loops()
    fits = Fits(loops)
    figures = drawn(selftuned_pictures(loops, fits), tmp_path)
    assert fits.of("test") is fits.of("test")
    stribeck, loop, share = figures["friction_fit"].axes
    x, y = (np.asarray(part) for part in stribeck.lines[0].get_data())
    at = int(np.argmin(np.abs(x - 1e-3 * UM_PER_RAD)))
    v = x[at] / UM_PER_RAD
    assert y[at] == pytest.approx(level(LuGre(), v) + 0.4 * v, rel=1e-12)
    slow = x < 1.5
    assert np.all(np.asarray(stribeck.lines[2].get_ydata())[slow] < y[slow])
    true, test, sines = (np.asarray(line.get_ydata()) for line in loop.lines)
    assert np.abs(test - true).max() < 0.02 < 0.5 < np.abs(sines - true).max()
    assert [text.get_text() for text in share.texts] == ["not\nidenti-\nfiable"] * 2
    torque = np.asarray(figures["friction_test_record"].axes[2].lines[0].get_ydata())
    creeping = torque[round(3.0 / PERIOD_S) : round(7.0 / PERIOD_S)]
    assert LuGre().coulomb < creeping.max() < LuGre().static and -LuGre().static < creeping.min() < -LuGre().coulomb


@pytest.mark.parametrize("page", ["friction_compensation", "identify_friction"])
def test_the_images_of_a_page_exist_and_are_those_drawn_here(page):
    wanted = re.findall(r"\]\(images/(\w+)\.png\)", (ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8"))
    loops = Loops()
    names = {p.name for p in (*beaten_pictures(loops), *selftuned_pictures(loops))}
    assert wanted and set(wanted) <= names
    assert all((ROOT / "docs" / "images" / f"{name}.png").stat().st_size > 5000 for name in wanted)
