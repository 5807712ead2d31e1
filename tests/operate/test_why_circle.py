"""The polar plot of a circle that is being drawn: the last turn, and its figures."""

import json
import math

import numpy as np
import pytest

from leadscrew import Loop, resolve
from leadscrew.analysis.circular import simulation
from leadscrew.analysis.circular.paths import CCW, CircularTest, Turn
from leadscrew.analysis.circular.quantities import quantities
from leadscrew.analysis.circular.simulation import Circle as Asked
from leadscrew.analysis.circular.simulation import Machine, draw, with_reference
from leadscrew.operate.why import Circle
from leadscrew.references._sine import sine_motion
from leadscrew.util.errors import ValueRefused

COLUMNS = ["time", "command.position", "actual", "feedback", "y.actual", "y.feedback"]
RADIUS, FREQUENCY = 0.5, 0.5


def loops(radius: float = RADIUS, ahead: float = 0.5 * math.pi, frequency: float = FREQUENCY) -> list[Loop]:
    """Two axes of the ball-screw stage under sines, as a circle is operated; none of them is run."""
    study = resolve.study("fsmc_ballscrew")
    own = study.loop("ours.smc_4khz", "sine_slow")
    return [
        with_reference(own, sine_motion(amplitude=radius, frequency=frequency, phase=phase, offset=2.0))
        for phase in (ahead, 0.0)
    ]


def rows(count: int, way: int = 1, oval_um: float = 4.0, every: float = 1.0, first: int = 0) -> np.ndarray:
    """An oval: the radius differs by +-oval along the axes; so G is twice that, and the mean radius right."""
    t = (first + np.arange(count)) * every * 0.25e-3
    phi = way * 2.0 * math.pi * FREQUENCY * t
    r = RADIUS + 1e-3 * oval_um * np.cos(2.0 * phi)
    x, y = 2.0 + r * np.cos(phi), 2.0 + r * np.sin(phi)
    return np.column_stack((t, x, x, x + 1.0, y, y + 1.0))


def test_an_oval_shows_its_known_figures_whatever_the_chunks() -> None:
    whole, chunks = (Circle(loops(), COLUMNS) for _ in range(2))
    data = rows(20_000)
    whole.feed(data)
    at = 0
    for size in np.random.default_rng(0).integers(1, 900, 200):
        chunks.feed(data[at : at + size])
        at += int(size)
    chunks.feed(data[at:])
    view = whole.look()
    assert chunks.look() == view
    figures = view["figures"]
    assert figures["G"] == pytest.approx(8.0, abs=1e-3)
    assert (figures["F max"], figures["F min"]) == pytest.approx((4.0, -4.0), abs=1e-3)
    assert figures["radius error"] == pytest.approx(0.0, abs=0.02)
    angle, deviation = np.array(view["points"]).T
    np.testing.assert_allclose(deviation, 4.0 * np.cos(2.0 * np.radians(angle)), atol=2e-3)
    assert np.ptp(angle) > 359.0
    assert len(angle) <= 721
    assert view["enlarge"] == 1.0
    json.dumps(view, allow_nan=False)


@pytest.mark.parametrize("period", [4000, 4001, 4002])
def test_a_peak_of_one_period_counts_in_the_figures_whichever_period_it_is(period: int) -> None:
    circle, data = Circle(loops(), COLUMNS), rows(8_000)
    data[period, [2, 4]] += 0.020 * (data[period, [2, 4]] - 2.0) / RADIUS  # 20 um outwards
    circle.feed(data)
    x, y = data[:, 2] - 2.0, data[:, 4] - 2.0
    expected = quantities(CircularTest(RADIUS, Turn(CCW, x, y), None)).ccw
    figures = circle.look()["figures"]
    assert expected is not None and expected.set_up_largest > 15.0
    assert figures["G"] == pytest.approx(expected.circular, rel=1e-12)
    assert figures["F max"] == pytest.approx(expected.set_up_largest, rel=1e-12)
    assert figures["radius error"] == pytest.approx(expected.mean_radial, rel=1e-9)
    assert len(circle.look()["points"]) <= 720


@pytest.mark.slow
def test_a_turn_so_slow_that_periods_are_left_out_says_so() -> None:
    slow, quick = Circle(loops(frequency=0.1), COLUMNS), Circle(loops(), COLUMNS)
    phi = 2.0 * math.pi * 0.1 * 0.25e-3 * np.arange(41_000)
    x, y = 2.0 + RADIUS * np.cos(phi), 2.0 + RADIUS * np.sin(phi)
    slow.feed(np.column_stack((phi, x, x, x, y, y)))
    quick.feed(rows(9_000))
    assert slow.look()["text"] == "last turn, ccw, figures of every 2. period"
    assert quick.look()["text"] == "last turn, ccw"


def test_the_other_way_round_and_the_axes_the_other_way() -> None:
    circle = Circle(loops(ahead=-0.5 * math.pi), COLUMNS)
    circle.feed(rows(9_000, way=-1))
    assert circle.look()["figures"]["G"] == pytest.approx(8.0, abs=1e-3)
    wrong = Circle(loops(), COLUMNS)
    wrong.feed(rows(9_000, way=-1))
    assert wrong.look()["figures"] == {}
    assert "the points run cw" in wrong.look()["text"]


def test_the_last_turn_counts_not_the_ones_before() -> None:
    circle = Circle(loops(), COLUMNS)
    circle.feed(rows(9_000, oval_um=40.0))
    assert circle.look()["figures"]["G"] == pytest.approx(80.0, rel=1e-3)
    circle.feed(rows(8_400, first=9_000))
    assert circle.look()["figures"]["G"] == pytest.approx(8.0, rel=1e-3)


def test_before_a_turn_there_are_points_but_no_figures() -> None:
    circle = Circle(loops(), COLUMNS)
    assert circle.look()["points"] == []
    circle.feed(rows(2_000))
    view = circle.look()
    assert view["figures"] == {}
    assert view["turned"] == pytest.approx(0.25, abs=0.01)
    assert len(view["points"]) > 100


def test_another_radius_begins_another_turn() -> None:
    circle = Circle(loops(), COLUMNS)
    circle.feed(rows(9_000))
    circle.feed(rows(10, first=9_000), loops(radius=0.6))
    assert circle.look()["figures"] == {}
    assert circle.look()["radius"] == 0.6
    circle.feed(rows(10, first=9_010), [loops(radius=0.6)[0], loops(radius=0.7)[1]])
    assert "a circle has two that are alike" in circle.look()["text"]
    circle.feed(rows(9_000), loops())
    assert circle.look()["figures"]["G"] == pytest.approx(8.0, abs=1e-3)


def test_what_is_no_circle_is_refused() -> None:
    with pytest.raises(ValueRefused, match="no circle"):
        Circle(loops()[:1], COLUMNS)
    with pytest.raises(ValueRefused, match=r"needs the column y\.actual"):
        Circle(loops(), COLUMNS[:4])


def test_a_hundred_turns_are_kept_and_drawn_as_one_is() -> None:
    """What a look costs hangs on one turn; the milliseconds are a row of ``leadscrew bench``."""
    one, many = Circle(loops(), COLUMNS), Circle(loops(), COLUMNS)
    one.feed(rows(8_000))
    for turn in range(100):
        many.feed(rows(8_000, first=8_000 * turn))
    assert many.ring.nbytes == one.ring.nbytes
    assert len(many.look()["points"]) == len(one.look()["points"]) <= 720


@pytest.mark.slow
def test_a_turn_that_a_machine_draws_has_the_figures_of_the_ball_bar_test() -> None:
    """Against :func:`draw` of the same stage, circle and feed, which runs and samples it by itself."""
    study = resolve.study("fsmc_ballscrew")
    own = study.loop("ours.smc_4khz", "sine_slow")
    values = {"radius": 2.0, "speed": 2.0, "start": 0.0, "turning": 1.0}
    first = own.signals["actual"]
    values |= {"centre_x": first - 2.0, "centre_y": first}
    pair = [with_reference(own, made(**values)) for made in (simulation.circle_x_motion, simulation.circle_y_motion)]
    columns = ["time", "actual", "y.actual"]
    circle = Circle(pair, columns)
    lives = [loop.start(replicate=k) for k, loop in enumerate(pair)]
    per_turn = round(math.pi / own.period)
    for _ in range(23):
        runs = [live.advance(per_turn // 10, record="actual") for live in lives]
        circle.feed(np.column_stack((runs[0]["time"], runs[0]["actual"], runs[1]["actual"])))
    test = draw(Machine(own, own), Asked(radius_mm=2.0, feed_mm_min=240.0, direction="ccw"))
    expected = quantities(test).ccw
    figures = circle.look()["figures"]
    assert expected is not None
    assert figures["G"] == pytest.approx(expected.circular, rel=0.05)
    assert figures["F max"] == pytest.approx(expected.set_up_largest, abs=0.05 * expected.circular)
    assert figures["F min"] == pytest.approx(expected.set_up_smallest, abs=0.05 * expected.circular)
