"""From a measured line to the next offsets: known errors by hand, scans, placings, and what is refused."""

import math

import numpy as np
import pytest

from leadscrew.paths import shapes
from leadscrew.paths.path import Path
from leadscrew.paths.segments import Line
from leadscrew.tangent import machine
from leadscrew.tangent.compensate import Learning, compensated
from leadscrew.tangent.deviation import cutoff_of, deviation_of, errors_along, noise_of
from leadscrew.tangent.emit import program
from leadscrew.tangent.machine import Scan, marks_of, scanned
from leadscrew.tangent.matching import Placing, by_marks, fitted, thinned
from leadscrew.tangent.measurement import Trace
from leadscrew.tangent.program import program_of
from leadscrew.tangent.settings import Settings
from leadscrew.tangent.stroke import strokes_of
from leadscrew.util.errors import DataError, ValueRefused

PLAIN = Settings()
NONE = np.empty(0)


def points(x, y, closed=False, stroke=0):
    """A measured line of points."""
    return Trace(stroke, np.asarray(x, dtype=float), np.asarray(y, dtype=float), NONE, NONE, closed, "scan.csv")


def stroke_of(path, settings=PLAIN):
    (stroke,) = strokes_of([path], settings)
    return stroke


def line_with(stroke, error, step=0.02):
    """Points of the curve whose tangent is the stroke's plus ``error(s)`` deg: by small steps."""
    s = np.linspace(0.0, stroke.length, round(stroke.length / step) + 1)
    middle = 0.5 * (s[1:] + s[:-1])
    angle = np.radians(stroke.at(middle).heading + error(middle))
    start = stroke.at(0.0)
    x = float(start.x) + np.concatenate(([0.0], np.cumsum(np.diff(s) * np.cos(angle))))
    y = float(start.y) + np.concatenate(([0.0], np.cumsum(np.diff(s) * np.sin(angle))))
    return s, x, y


@pytest.mark.parametrize(
    "shape", [pytest.param(shapes.wave, marks=pytest.mark.slow), pytest.param(shapes.flower, marks=pytest.mark.slow),
              shapes.rounded_rectangle]
)  # fmt: skip
def test_the_error_of_a_line_made_with_a_known_one_is_found(shape):
    stroke = stroke_of(shape())
    _, x, y = line_with(stroke, lambda s: 2.0 + 3.0 * np.sin(2.0 * np.pi * s / 60.0))
    keep = np.append(np.arange(0, x.size - 12, 25), x.size - 1)
    found = deviation_of(stroke, x[keep], y[keep], None, "line")
    wanted = 2.0 + 3.0 * np.sin(2.0 * np.pi * found.travel / 60.0)
    assert np.abs(found.error - wanted)[20:-20].max() < 0.25
    assert math.sqrt(np.mean((found.error - wanted) ** 2)) < 0.06
    assert found.length == pytest.approx(stroke.length, rel=2e-4)


@pytest.mark.slow
def test_the_cut_off_halves_a_wave_of_its_length():
    stroke = stroke_of(Path([Line((0.0, 0.0), (400.0, 0.0))]))
    _, x, y = line_with(stroke, lambda s: 1.0 * np.sin(2.0 * np.pi * s / 16.0), 0.25)
    for cutoff, left in ((16.0, 0.5), (8.0, 1.0 / (1.0 + 0.5**4)), (32.0, 1.0 / 17.0)):
        found = deviation_of(stroke, x, y, cutoff, "line")
        inside = (found.travel > 80.0) & (found.travel < 320.0)
        assert np.abs(found.error[inside]).max() == pytest.approx(left, rel=0.02)


@pytest.mark.slow
def test_the_noise_of_a_scan_is_told_and_leaves_as_much_in_the_angle_as_is_said():
    stroke = stroke_of(shapes.wave())
    at = stroke.at(stroke.grid(0.5))
    draw = np.random.default_rng(3)
    seen = []
    for _ in range(6):
        x, y = (v + 0.05 * draw.standard_normal(v.size) for v in (at.x, at.y))
        found = deviation_of(stroke, x, y, None, "scan")
        assert found.noise == pytest.approx(0.05, rel=0.15)
        seen.append(found.error[100:-100])
    assert math.sqrt(np.mean(np.square(seen))) == pytest.approx(0.15, rel=0.25)
    assert cutoff_of(0.1, 0.5) > cutoff_of(0.05, 0.5) > cutoff_of(0.05, 0.1) > cutoff_of(0.0, 0.1) == 4.0
    assert noise_of(np.ones(4)) == 0.0


def test_one_angle_all_along_becomes_one_offset_against_it():
    stroke = stroke_of(Path([Line((0.0, 0.0), (100.0, 0.0))]))
    _, x, y = line_with(stroke, lambda s: 0.0 * s + 1.8, 0.5)
    found = compensated([stroke], PLAIN, [points(x, y)])
    assert found.strokes[0].offset([10.0, 50.0, 90.0]) == pytest.approx([-2.0] * 3, abs=1e-6)
    assert found.rms() == pytest.approx(1.8) and found.rms(True) < 1e-3 and found.largest == pytest.approx(2.0)
    kept = compensated([stroke], PLAIN, [points(x, y)], Learning(learning=0.5, gain=1.0))
    assert kept.strokes[0].offset(50.0) == pytest.approx(-0.9)
    # With the offset the same error is left over: so it takes as much again.
    again = compensated(found.strokes, PLAIN, [points(x, y)])
    assert again.strokes[0].offset(50.0) == pytest.approx(-4.0, abs=1e-6)


def test_errors_measured_themselves_need_no_points():
    stroke = stroke_of(Path([Line((0.0, 0.0), (100.0, 0.0))]))
    s = np.linspace(0.0, 100.0, 51)
    found = compensated([stroke], PLAIN, [Trace(1, NONE, NONE, s, 0.0 * s - 0.9, False, "gauge.csv")])
    assert found.strokes[0].offset(50.0) == pytest.approx(1.0)


def test_an_offset_beyond_its_limit_is_held_and_said():
    stroke = stroke_of(Path([Line((0.0, 0.0), (100.0, 0.0))]))
    s = np.linspace(0.0, 100.0, 201)
    error = np.where(s < 50.0, -18.0, 0.0)
    found = compensated([stroke], PLAIN, [Trace(1, NONE, NONE, s, error, False, "gauge.csv")])
    assert found.largest == 15.0 and found.learned[0].clipped_mm == pytest.approx(49.0, abs=2.0)
    assert any("held to 15 deg along" in n for n in found.notes)


@pytest.mark.slow
@pytest.mark.parametrize("align", ["marks", "shape"])
def test_a_piece_that_lay_elsewhere_is_brought_back(align):
    stroke = stroke_of(shapes.wave())
    _, x, y = line_with(stroke, lambda s: 2.0 * np.sin(2.0 * np.pi * s / 60.0), 0.25)
    scan = Scan(dx=30.0, dy=-80.0, turn_deg=140.0)
    marks = marks_of([stroke], scan) if align == "marks" else ()
    found = compensated([stroke], PLAIN, [points(*scan.of(x, y))], align=align, marks=marks)
    assert (found.placing.turn_deg + 140.0 + 180.0) % 360.0 - 180.0 == pytest.approx(0.0, abs=1.5)
    straight = compensated([stroke], PLAIN, [points(x, y)])
    limit = 0.02 if align == "marks" else 1.5
    assert np.abs(found.learned[0].before - straight.learned[0].before).max() < limit


@pytest.mark.parametrize(
    ("first", "last", "covers"),
    [(0.0, 100.0, True), (1.4, 98.6, True), (-1.4, 101.4, True), (1.6, 100.0, False), (-1.6, 100.0, False),
     (0.0, 98.4, False), (0.0, 101.6, False)],
)  # fmt: skip
def test_errors_measured_along_a_line_of_100_mm_may_miss_its_ends_by_1_5_mm(first, last, covers):
    stroke = stroke_of(Path([Line((0.0, 0.0), (100.0, 0.0))]))
    travel = np.linspace(first, last, 30)
    if covers:
        assert errors_along(stroke, travel, np.full(30, 2.0), "log.csv").spacing == pytest.approx((last - first) / 29)
    else:
        with pytest.raises(DataError, match=r"log\.csv: goes from .* does not cover the path: expected 0 to 100\.0 mm"):
            errors_along(stroke, travel, np.full(30, 2.0), "log.csv")


def test_an_error_that_no_cut_has_is_refused_as_another_line():
    stroke = stroke_of(Path([Line((0.0, 0.0), (100.0, 0.0))]))
    travel = np.linspace(0.0, 100.0, 101)
    spike = np.where(travel == 50.0, 60.0, 0.0)
    assert errors_along(stroke, travel, np.full(101, -20.0), "log.csv").error[0] == -20.0
    assert errors_along(stroke, travel, -spike, "log.csv").error[50] == -60.0
    for error in (np.full(101, 20.1), np.full(101, -20.1), -1.01 * spike):
        with pytest.raises(DataError, match="this is not the cut of this path"):
            errors_along(stroke, travel, error, "log.csv")


def test_a_line_traced_backwards_or_as_a_closed_one_is_taken_from_the_plunge_on():
    stroke = stroke_of(shapes.rounded_rectangle())
    at = stroke.at(np.linspace(0.0, stroke.length, 800)[:-1])
    for x, y in ((at.x[::-1], at.y[::-1]), (np.roll(at.x, 333), np.roll(at.y, 333))):
        found = compensated([stroke], PLAIN, [points(x, y, closed=True)])
        assert found.rms() < 0.25
    wave = stroke_of(shapes.wave())
    at = wave.at(wave.grid(0.5))
    found = compensated([wave], PLAIN, [points(at.x[::-1], at.y[::-1])])
    assert found.rms() < 0.01 and "turned round" in found.notes[0]


def test_traced_lines_find_their_strokes_and_what_was_not_measured_stays():
    paths = [Path([Line((0.0, k), (60.0, k))]) for k in (0.0, 20.0, 40.0)]
    strokes = strokes_of(paths, PLAIN)
    traces = [points(np.linspace(0, 60, 99), np.full(99, k) + np.linspace(0, 0.01 * k, 99)) for k in (40.0, 0.0, 20.0)]
    found = compensated(strokes, PLAIN, traces)
    assert [k.number for k in found.learned] == [1, 2, 3]
    assert [float(k.before[50]) for k in found.learned] == pytest.approx([0.0, 0.191, 0.382], abs=0.002)
    only = compensated(strokes, PLAIN, [traces[0]._replace(stroke=3)])
    assert only.strokes[0] is strokes[0] and "not measured, kept as they were: stroke 1, 2" in only.notes


def test_a_stray_point_is_left_out_and_said_and_many_are_only_said():
    stroke = stroke_of(Path([Line((0.0, 0.0), (100.0, 0.0))]))
    _, x, y = line_with(stroke, lambda s: 0.0 * s + 1.8, 0.5)
    astray = y.copy()
    astray[80] += 2.0
    found = compensated([stroke], PLAIN, [points(x, astray)])
    assert found.largest == pytest.approx(2.0, abs=1e-3)
    (note,) = found.notes
    assert note == "scan.csv: 1 point of stroke 1 (near 40.0, 3.3) up to 2 mm off the line of the others: left out"
    astray = y.copy()
    astray[[30, 80, 130]] += 0.55
    found = compensated([stroke], PLAIN, [points(x, astray)])
    assert "so many are not left out: the error is uncertain there" in found.notes[0]


def test_a_dense_scan_is_put_together_and_tells_the_same():
    stroke = stroke_of(Path([Line((0.0, 0.0), (100.0, 0.0))]))
    draw = np.random.default_rng(4)
    _, x, y = line_with(stroke, lambda s: 2.0 * np.sin(s / 15.0), 0.001)
    noisy = [v + 0.02 * draw.standard_normal(v.size) for v in (x, y)]
    found = compensated([stroke], PLAIN, [points(*noisy)])
    (learned,) = found.learned
    off = learned.before - 2.0 * np.sin(learned.travel / 15.0)
    assert math.sqrt(np.mean(off[5:-5] ** 2)) < 0.06 and np.abs(off).max() < 0.4
    assert learned.seen.noise == pytest.approx(0.02, rel=0.1) and learned.seen.spacing == pytest.approx(0.001, rel=0.05)
    assert learned.seen.travel.size < 1100


def test_points_are_put_together_by_their_means_with_the_ends_of_the_line():
    x = np.linspace(0.0, 10.0, 1001)
    u, v, count = thinned(x, 2.0 * x, 10.0, 0.1)
    assert count == 10 and u.size == 102 and (u[0], u[-1]) == pytest.approx((0.0, 10.0), abs=6e-3)
    assert v == pytest.approx(2.0 * u)
    assert thinned(x[::100], x[::100], 10.0, 0.1)[2] == 1
    # What jumps is not smeared.
    assert thinned(np.where(x < 5.0, x, x + 40.0), x, 10.0, 0.1)[2] == 1


def wave_points(step=0.5):
    stroke = stroke_of(shapes.wave())
    at = stroke.at(stroke.grid(step))
    return stroke, at.x, at.y


def refusal(trace, align="none", marks=(), stroke=None):
    with pytest.raises((DataError, ValueRefused)) as refused:
        compensated([stroke or stroke_of(shapes.wave())], PLAIN, [trace], align=align, marks=marks)
    return str(refused.value)


def test_what_is_not_the_cut_of_this_path_is_refused_in_a_sentence():
    _, x, y = wave_points()
    n = len(x)
    assert "does not cover the path: it is" in refusal(points(x[: n * 3 // 4], y[: n * 3 // 4]))
    assert "25.4 times as large" in refusal(points(25.4 * x, 25.4 * y)) and "mm read as inches" in refusal(
        points(25.4 * x, 25.4 * y)
    )
    assert "inches read as mm" in refusal(points(x / 25.4, y / 25.4))
    assert "not in order" in refusal(points(np.random.default_rng(1).permutation(x), y))
    swapped = np.r_[0 : n // 3, n // 2 : n, n // 3 : n // 2]
    assert "from point 771 to point 772 it jumps by 219 mm, 0.5 mm being usual" in refusal(
        points(x[swapped], y[swapped])
    )
    assert "too coarse: a point every 14" in refusal(points(x[::28], y[::28]))
    assert "3 points are too few" in refusal(points(x[:3], y[:3]))
    assert "all points are the same" in refusal(points(np.ones(50), np.ones(50)))
    assert "1 point is too few" in refusal(points([1.0], [2.0]))
    assert "is 10 times as large as stroke 1: another unit or scale?" in refusal(points(10.0 * x, 10.0 * y))
    assert "1 row is too few" in refusal(Trace(1, NONE, NONE, np.zeros(1), np.zeros(1), False, "gauge.csv"))
    assert "lies 300 mm from where stroke 1" in refusal(points(x + 300.0, y))
    other = shapes.flower().at(np.linspace(0.0, 394.0, 900))
    assert "jumps" not in (said := refusal(points(1.17 * other.x + 150.0, 1.17 * other.y)))
    assert "another line" in said or "this is not the cut of this path" in said
    assert "the program has 1 stroke only" in refusal(points(x, y, stroke=2))
    assert "travel does not rise after its entry 2" in refusal(
        Trace(1, NONE, NONE, np.array([0.0, 5.0, 4.0]), np.zeros(3), False, "gauge.csv")
    )
    assert "does not cover the path: expected 0 to 461.5 mm" in refusal(
        Trace(1, NONE, NONE, np.array([0.0, 300.0]), np.zeros(2), False, "gauge.csv")
    )


def test_two_strokes_need_a_number_for_each_row_or_a_line_each():
    strokes = strokes_of([shapes.wave(), shapes.flower()], PLAIN)
    _, x, y = wave_points()
    with pytest.raises(DataError, match="the program has 2 strokes"):
        compensated(strokes, PLAIN, [points(x, y)])
    with pytest.raises(DataError, match=r"2 lines measured, the program has 1 stroke$"):
        compensated(strokes[:1], PLAIN, [points(x, y), points(x, y)])


def test_marks_are_checked():
    assert by_marks([(0, 0, 10, 5), (100, 0, 10, 105)]) == pytest.approx(Placing(-90.0, -5.0, 10.0))
    for pairs, why in (
        ([(0, 0, 0, 0)], "two or more"),
        ([(0, 0, 0, 0), (5, 0, 5, 0)], "the marks are 5 mm apart"),
        ([(0, 0, 0, 0), (100, 0, 110, 0)], "do not lie to each other"),
    ):
        with pytest.raises(ValueRefused, match=why):
            by_marks(pairs)
    assert "belong together" in refusal(points(*wave_points()[1:]), align="marks")
    assert "expected none, shape, marks" in refusal(points(*wave_points()[1:]), align="best")


def test_a_placing_is_the_best_turn_and_shift_of_all():
    from scipy.spatial.transform import Rotation

    draw = np.random.default_rng(7)
    a = draw.standard_normal((40, 2)) + np.array([3.0, 1.0])
    b = a @ np.array([[0.6, 0.8], [-0.8, 0.6]]) + 0.2 * draw.standard_normal((40, 2)) + np.array([0.0, -2.0])
    found = fitted(a, b)
    flat = [np.column_stack((p - p.mean(axis=0), np.zeros(40))) for p in (a, b)]
    turn, _ = Rotation.align_vectors(flat[1], flat[0])
    assert found.turn_deg == pytest.approx(turn.as_euler("zyx", degrees=True)[0])
    assert np.column_stack(found.of(*a.T)).mean(axis=0) == pytest.approx(b.mean(axis=0))


@pytest.mark.parametrize(
    "how", [Learning(learning=0.0), Learning(gain=math.nan), Learning(cutoff_mm=0.1), Learning(limit_deg=90.0)]
)
def test_settings_of_learning_are_refused_with_their_range(how):
    stroke, x, y = wave_points()
    with pytest.raises(ValueRefused, match=r"allowed range|not a number"):
        compensated([stroke], PLAIN, [points(x, y)], how)


def second(shape, material, noise=0.0, placed=False):
    """Errors of a piece without compensation and of the next, each with another texture, through G-code and scan."""
    text = program(strokes_of([shape()], PLAIN), PLAIN)
    errors = []
    for piece in (1, 2):
        read = program_of(text)
        cuts = machine.cut(read.strokes, read.settings, material, seed=piece)
        errors.append(machine.rms(cuts))
        scan = Scan(noise, *((40.0, -25.0, 12.0) if placed else (0.0, 0.0, 0.0)), seed=piece)
        traces = [points(x, y, stroke=k) for k, (x, y) in enumerate(scanned(cuts, scan), start=1)]
        marks = marks_of(read.strokes, scan) if placed else ()
        found = compensated(read.strokes, read.settings, traces, align="marks" if placed else "none", marks=marks)
        text = program(found.strokes, read.settings)
    return errors


def test_the_second_piece_has_a_third_of_the_error_of_the_first():
    first, then = second(shapes.rounded_rectangle, "fabric")
    assert then < first / 3.0


@pytest.mark.slow
@pytest.mark.parametrize("shape", [shapes.wave, shapes.flower, shapes.rounded_rectangle])
def test_so_it_has_with_the_noise_of_a_scan_and_a_piece_that_lay_elsewhere(shape):
    first, then = second(shape, "fabric", noise=0.05, placed=True)
    assert then < first / 3.0


@pytest.mark.slow
def test_the_program_of_the_next_piece_says_the_offsets_that_were_learned():
    stroke = stroke_of(shapes.wave())
    _, x, y = line_with(stroke, lambda s: 3.0 * np.sin(s / 30.0), 0.5)
    found = compensated([stroke], PLAIN, [points(x, y)])
    (read,) = program_of(program(found.strokes, Settings(angle_tolerance=0.1))).strokes
    grid = np.linspace(5.0, stroke.length - 5.0, 300)
    assert np.abs(read.offset(grid) - found.strokes[0].offset(grid)).max() < 0.15


@pytest.mark.slow
def test_a_stroke_too_short_to_be_told_stays_as_it_was():
    strokes = strokes_of([Path([Line((0.0, 0.0), (60.0, 0.0))]), Path([Line((0.0, 9.0), (2.0, 9.0))])], PLAIN)
    traces = [points(np.linspace(0.0, 60.0, 99), np.zeros(99), stroke=1), points([0.0, 2.0], [9.0, 9.0], stroke=2)]
    found = compensated(strokes, PLAIN, traces)
    assert found.strokes[1] is strokes[1] and found.notes == ["too short to be matched, kept as they were: stroke 2"]
    with pytest.raises(DataError, match="none can be matched"):
        compensated(strokes, PLAIN, traces[1:])
