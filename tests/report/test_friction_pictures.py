"""Pictures of friction and backlash: labelled, nothing empty, and what they show is what the models compute."""

import numpy as np
import pytest

from leadscrew.report import friction

QUICK = (friction.friction_velocity_figure, friction.presliding_figure, friction.classic_figure)
SLOW = (friction.break_away_figure, friction.stick_slip_figure, friction.modern_figure)


def assert_readable(figure):
    for ax in figure.axes:
        assert "(" in ax.get_xlabel() and ax.get_title()
        assert ax.lines and all(np.isfinite(line.get_ydata()).all() for line in ax.lines)
    assert any("(" in ax.get_ylabel() for ax in figure.axes)
    (legend,) = figure.legends
    named = {text.get_text() for text in legend.get_texts()}
    assert named == {line.get_label() for ax in figure.axes for line in ax.lines}


@pytest.mark.parametrize("draw", QUICK, ids=lambda d: d.__name__)
def test_every_line_is_named_and_every_axis_has_its_unit(draw):
    assert_readable(draw())


@pytest.mark.slow
@pytest.mark.parametrize("draw", SLOW, ids=lambda d: d.__name__)
def test_every_line_is_named_and_every_axis_has_its_unit_where_drawing_takes_runs(draw):
    assert_readable(draw())


def test_the_picture_of_inner_loops_shows_who_remembers():
    first = [ax.get_title().split(": ")[1].split(" N, then ") for ax in friction.presliding_figure().axes]
    apart = [abs(float(a) - float(b.removesuffix(" N"))) for a, b in first]
    assert apart[0] > 0.2 and apart[1] > 0.2 and apart[2] == 0.0


def test_the_picture_of_the_play_has_the_width_of_the_play():
    play = next(line for line in friction.classic_figure().axes[0].lines if line.get_label().startswith("equal"))
    drive, table = play.get_data()
    assert max(drive - table) == pytest.approx(1.0) and min(drive - table) == pytest.approx(-1.0)
    assert np.ptp(drive - table) == pytest.approx(2.0)


@pytest.mark.slow
def test_after_a_reversal_an_elastic_impact_swings_longer_than_a_soft_one():
    """1 mm at 1 Hz: 50 ms after the flank change the table still swings with a restitution of 0.9, not with 0.05."""
    swings = []
    for restitution in (0.9, 0.05):
        run = friction.imposed_reversal(1e-3, 2.0 * np.pi, restitution, sample=2e-4)
        twist = run["plant.motor"] - run["plant.table"]
        assert np.abs(run["plant.motor"] - 1e-3 * np.sin(2.0 * np.pi * run.time)).max() < 1e-8
        since = run.time - 0.25
        swings.append([np.ptp(twist[(since > a) & (since < a + 0.01)]) for a in (0.015, 0.05)])
    assert swings[0][0] > 3e-7 and 3e-8 < swings[0][1] < 0.5 * swings[0][0]
    assert swings[1][1] < 1e-8
