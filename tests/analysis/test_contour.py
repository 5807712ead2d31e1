"""Contour error of shapes whose distance is known."""

import numpy as np
import pytest

from leadscrew.analysis.contour import contour_error, following_error


def test_lag_along_a_line_is_following_error_and_no_contour_error():
    t = np.linspace(0, 1, 101)
    command = 30 * t, 40 * t
    actual = 30 * (t - 0.1), 40 * (t - 0.1)
    following = following_error(*command, *actual)
    np.testing.assert_allclose(following.distance, 5.0)
    contour = contour_error(*command, *actual)
    np.testing.assert_allclose(contour.signed[11:], 0.0, atol=1e-12)


@pytest.mark.parametrize("window", [None, 30])
def test_offset_of_a_line_is_positive_to_the_left(window):
    x = np.linspace(0, 10, 201)
    left = contour_error(x, 0 * x, x, 0 * x + 0.02, window)
    np.testing.assert_allclose(left.signed, 0.02)
    np.testing.assert_allclose(left.nearest_x, x, atol=1e-12)
    np.testing.assert_allclose(contour_error(x, 0 * x, x, 0 * x - 0.02, window).signed, -0.02)
    np.testing.assert_allclose(contour_error(x[::-1], 0 * x, x, 0 * x - 0.02, None).signed, 0.02)


@pytest.mark.parametrize("window", [None, 200])
def test_a_lagging_loop_cuts_a_circle_by_the_radius_it_loses(window):
    """Both axes behind by the same lag: the actual circle is smaller and behind, the contour error is the radius."""
    phi = np.linspace(0, 2 * np.pi, 2001)
    command = 50 * np.cos(phi), 50 * np.sin(phi)
    actual = 49.9 * np.cos(phi - 0.2), 49.9 * np.sin(phi - 0.2)
    contour = contour_error(*command, *actual, window)
    chord = 50 * (phi[1] / 2) ** 2 / 2
    inside = slice(100, None) if window else slice(None)
    np.testing.assert_allclose(contour.signed[inside], 0.1, atol=1.1 * chord)
    assert contour.rms == pytest.approx(0.1, abs=2 * chord) or window
    assert following_error(*command, *actual).distance.min() > 9.0


def test_outside_a_corner_the_distance_is_to_the_corner():
    contour = contour_error([0, 10, 10], [0, 0, 10], [13.0], [-4.0])
    assert contour.distance[0] == pytest.approx(5.0) and contour.signed[0] == pytest.approx(-5.0)
    assert (contour.nearest_x[0], contour.nearest_y[0]) == (10.0, 0.0)
    straight_on = contour_error([0, 10], [0, 0], [12.0], [0.0])
    assert straight_on.signed[0] == 2.0 and straight_on.largest == 2.0


def test_commands_at_rest_are_passed_over_and_numbered_as_recorded():
    x, y = np.array([0, 0, 0, 5, 5, 5, 10.0]), np.zeros(7)
    contour = contour_error(x, y, x, y + 1, None)
    np.testing.assert_allclose(contour.signed, 1.0)
    assert contour.segment.tolist() == [2, 2, 2, 2, 2, 2, 5]
    np.testing.assert_allclose(contour_error(x, y, x, y + 1, 1).signed, 1.0)


def test_a_window_keeps_a_crossing_path_apart():
    """A figure of eight: near the crossing the other branch is nearer to a point that lags off its own."""
    s = np.linspace(0, 2 * np.pi, 4001)
    command = 10 * np.sin(s), 5 * np.sin(2 * s)
    k = 2000
    tangent = np.array([-1.0, 1.0]) / np.sqrt(2)
    normal = np.array([-tangent[1], tangent[0]])
    actual = np.array(command)
    actual[:, k] += 0.3 * normal
    free = contour_error(*command, *actual)
    near = contour_error(*command, *actual, window=50)
    assert free.distance[k] < 0.01
    assert near.signed[k] == pytest.approx(0.3, rel=2e-3)


def test_chunks_do_not_change_the_result(monkeypatch):
    rng = np.random.default_rng(1)
    command, actual = rng.normal(size=(2, 60)), rng.normal(size=(2, 90))
    whole = contour_error(*command, *actual)
    monkeypatch.setattr("leadscrew.analysis.contour.CHUNK", 200)
    np.testing.assert_array_equal(contour_error(*command, *actual).signed, whole.signed)
    fine = np.linspace(0, 1, 2001)
    points = np.concatenate([command[:, i, None] * (1 - fine) + command[:, i + 1, None] * fine for i in range(59)], 1)
    brute = [np.hypot(points[0] - x, points[1] - y).min() for x, y in actual.T]
    np.testing.assert_allclose(whole.distance, brute, atol=2e-3)


def test_arrays_that_do_not_match_are_refused():
    with pytest.raises(ValueError, match="does not move"):
        contour_error([1, 1], [2, 2], [0.0], [0.0])
    with pytest.raises(ValueError, match="one length"):
        contour_error([1, 2], [2], [0.0], [0.0])
    with pytest.raises(ValueError, match="not finite"):
        contour_error([1, 2], [2, 2], [np.nan], [0.0])
    with pytest.raises(ValueError, match="one by one"):
        following_error([1, 2], [2, 2], [0.0], [0.0])
