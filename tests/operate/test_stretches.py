"""A session in figures, by hand: errors of a stretch and the envelope of a long run."""

import numpy as np
import pytest

from leadscrew.report.session import Envelope, Stretch


def test_the_error_of_a_stretch_is_that_of_all_its_rows_whatever_its_sign():
    found = Stretch(0, [])
    found.add(np.array([[3.0, -1.0], [-4.0, 0.0]]))
    found.add(np.array([[0.0, 0.5]]))
    found.add(np.zeros((0, 2)))
    assert found.rows == 3 and found.largest.tolist() == [4.0, 1.0]
    assert found.rms == pytest.approx([np.sqrt(25.0 / 3.0), np.sqrt(1.25 / 3.0)], rel=1e-14)


@pytest.mark.parametrize("cuts", [(), (1,), (2, 3, 6)])
def test_a_plot_of_few_points_has_the_extremes_of_each_piece_at_the_time_it_begins(cuts):
    x = np.array([0.0, 5.0, 1.0, -3.0, 2.0, 2.0, 7.0])
    plot = Envelope(["x", "gone"], 7, 0.5, buckets=3)
    for rows in np.split(x[:, None], cuts):
        plot.feed(["x"], rows)
    t, lines = plot.lines()
    assert t.tolist() == [0.0, 0.0, 1.5, 1.5, 3.0, 3.0]
    assert lines[:, 0].tolist() == [0.0, 5.0, -3.0, 2.0, 7.0, 7.0] and np.isnan(lines[:, 1]).all()


def test_a_short_run_is_drawn_row_by_row():
    plot = Envelope(["x"], 4, 0.25)
    plot.feed(["x"], np.arange(4.0)[:, None])
    t, lines = plot.lines()
    assert t.tolist() == [0.0, 0.25, 0.5, 0.75] and lines[:, 0].tolist() == [0.0, 1.0, 2.0, 3.0]
