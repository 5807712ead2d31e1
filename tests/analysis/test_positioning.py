"""The quantities of ISO 230-2 against numbers worked by hand and a second computation; the door for measured files."""

import math
import random
import statistics
from pathlib import Path

import numpy as np
import pytest

from leadscrew.analysis.positioning import example, positioning, read_positioning
from leadscrew.util.errors import DataError, ValueRefused

TARGETS = (10.0, 100.0)
UP = ((0.0, 1.0, 2.0), (1.0, 3.0, 5.0))
DOWN = ((3.5, 4.0, 4.5), (1.0, 1.0, 1.0))
"""Means 1, 3 and 4, 1; estimators 1, 2 and 0.5, 0: every quantity can be worked out on paper."""


def test_an_example_worked_by_hand():
    found = positioning(TARGETS, UP, DOWN)
    up, down, both = found.up, found.down, found.both
    assert up.mean.tolist() == [1.0, 3.0] and down.mean.tolist() == [4.0, 1.0]
    assert up.s.tolist() == [1.0, 2.0] and down.s.tolist() == [0.5, 0.0]
    assert up.repeatability_at.tolist() == [4.0, 8.0] and up.repeatability == 8.0
    assert down.repeatability_at.tolist() == [2.0, 0.0] and down.repeatability == 2.0
    assert both.reversal_at.tolist() == [-3.0, 2.0]
    assert (both.reversal, both.mean_reversal) == (3.0, -0.5)
    # max(2 + 1 + 3, 4, 2) and max(4 + 0 + 2, 8, 0)
    assert both.repeatability_at.tolist() == [6.0, 8.0] and both.repeatability == 8.0
    assert (up.systematic, down.systematic, both.systematic) == (2.0, 3.0, 3.0)
    assert both.mean.tolist() == [2.5, 2.0] and both.mean_error == 0.5
    # (3 + 4) - (1 - 2); (4 + 1) - (1 - 0); and over both directions
    assert (up.accuracy, down.accuracy, both.accuracy) == (8.0, 4.0, 8.0)


def by_the_definitions(targets, up, down):
    """The axis' quantities again: plain Python, no arrays, two-pass deviations."""

    def mean(values):
        return math.fsum(values) / len(values)

    x = {("+", i): mean(v) for i, v in enumerate(up)} | {("-", i): mean(v) for i, v in enumerate(down)}
    s = {("+", i): statistics.stdev(v) for i, v in enumerate(up)}
    s |= {("-", i): statistics.stdev(v) for i, v in enumerate(down)}
    n = range(len(targets))
    reversal = [x["+", i] - x["-", i] for i in n]
    r = [max(2 * s["+", i] + 2 * s["-", i] + abs(reversal[i]), 4 * s["+", i], 4 * s["-", i]) for i in n]
    middle = [0.5 * (x["+", i] + x["-", i]) for i in n]
    found = {
        "reversal": max(map(abs, reversal)),
        "mean_reversal": mean(reversal),
        "repeatability": max(r),
        "systematic": max(x.values()) - min(x.values()),
        "mean_error": max(middle) - min(middle),
        "accuracy": max(x[k] + 2 * s[k] for k in x) - min(x[k] - 2 * s[k] for k in x),
    }
    ways = {}
    for way in "+-":
        ways[way] = {
            "repeatability": max(4 * s[way, i] for i in n),
            "systematic": max(x[way, i] for i in n) - min(x[way, i] for i in n),
            "accuracy": max(x[way, i] + 2 * s[way, i] for i in n) - min(x[way, i] - 2 * s[way, i] for i in n),
        }
    return found, ways


@pytest.mark.parametrize("seed", range(20))
def test_every_quantity_agrees_with_a_second_computation(seed):
    draw = random.Random(seed)
    targets = sorted(draw.uniform(-500.0, 500.0) for _ in range(draw.randint(2, 12)))
    runs = draw.randint(2, 8)
    offset, spread = draw.uniform(-20, 20), draw.choice((0.01, 1.0, 20.0))
    up, down = (
        [[draw.gauss(at, spread) for _ in range(runs)] for at in (draw.gauss(off, 5.0) for _ in targets)]
        for off in (offset, -offset)
    )
    found = positioning(targets, up, down)
    expected, ways = by_the_definitions(targets, up, down)
    for name, value in expected.items():
        assert getattr(found.both, name) == pytest.approx(value, rel=1e-9, abs=1e-9), name
    for way, one in (("+", found.up), ("-", found.down)):
        for name, value in ways[way].items():
            assert getattr(one, name) == pytest.approx(value, rel=1e-9, abs=1e-9), (way, name)


def test_the_numbers_keep_the_order_that_their_definitions_force():
    found = positioning(TARGETS, UP, DOWN)
    assert found.both.accuracy >= max(found.up.accuracy, found.down.accuracy, found.both.systematic)
    assert found.both.systematic >= max(found.both.mean_error, found.both.reversal)
    assert found.both.repeatability >= max(found.up.repeatability, found.down.repeatability, found.both.reversal)


def test_a_shift_of_the_scale_changes_nothing_but_the_means():
    before = positioning(TARGETS, UP, DOWN)
    after = positioning(TARGETS, np.array(UP) + 7.0, np.array(DOWN) + 7.0)
    for name in ("reversal", "repeatability", "systematic", "mean_error", "accuracy"):
        assert getattr(after.both, name) == pytest.approx(getattr(before.both, name), abs=1e-12)


def test_a_perfect_compensation_leaves_the_scatter():
    left = positioning(TARGETS, UP, DOWN).compensated()
    assert left.both.systematic == left.both.reversal == 0.0
    assert left.both.accuracy == 8.0  # twice s to both sides at the worst target, s = 2
    assert left.up.s.tolist() == [1.0, 2.0]


def test_one_direction_gives_unidirectional_results_only():
    found = positioning(TARGETS, down_um=DOWN)
    assert found.up is None and found.both is None
    assert found.down.accuracy == 4.0
    assert any("one direction only" in n for n in found.notes())
    assert found.as_dict()["bidirectional"] is None


def test_what_the_standard_misses_is_said():
    noted = " ".join(positioning(TARGETS, UP, DOWN).notes())
    assert "3 runs" in noted and "2 targets" in noted
    at = np.array([12.0, 55.0, 103.0, 148.0, 201.0, 240.0])
    full = positioning(at, np.zeros((6, 5)), np.zeros((6, 5)))
    assert full.notes() == []
    exact = 2000.0 * np.linspace(0.0, 1.0, 10) ** 1.1  # the longest travel of this scheme, and just 5 targets a metre
    assert positioning(exact, np.zeros((10, 5)), np.zeros((10, 5))).notes() == []
    assert "equal distances" in positioning(np.arange(6.0), np.zeros((6, 5)), np.zeros((6, 5))).notes()[0]
    assert "5 a metre" in positioning(8.0 * at, np.zeros((6, 5)), np.zeros((6, 5))).notes()[0]
    assert "scheme of its own" in positioning(20.0 * at, np.zeros((6, 5)), np.zeros((6, 5))).notes()[0]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((TARGETS,), "at least one direction"),
        (((10.0,), ((0.0, 1.0),)), "two or more finite numbers"),
        (((10.0, 10.0), UP), "that rise"),
        (((10.0, math.nan), UP), "finite"),
        ((TARGETS, UP[:1]), "expected 2 targets"),
        ((TARGETS, ((1.0,), (2.0,))), "2 or more runs"),
        ((TARGETS, ((1.0, math.inf), (2.0, 1.0))), "not finite"),
        ((TARGETS, UP, ((1.0, 2.0), (1.0, 2.0))), "same number"),
    ],
)
def test_what_cannot_be_evaluated_is_refused(arguments, said):
    with pytest.raises(ValueRefused, match=said):
        positioning(*arguments)


# ---- files
HEADER = "target_mm,direction,run,deviation_um\n"


def lines_of(up=UP, down=DOWN, signs=("+", "-")):
    return [
        f"{target:g},{sign},{run},{value:g}\n"
        for sign, grid in zip(signs, (up, down), strict=True)
        for target, values in zip(TARGETS, grid, strict=True)
        for run, value in enumerate(values, 1)
    ]


def read(tmp_path, text, encoding="utf-8"):
    file = tmp_path / "test.csv"
    file.write_text(text, encoding=encoding)
    return read_positioning(file)


@pytest.mark.parametrize("signs", [("+", "-"), ("up", "down"), ("1", "-1"), ("Forward", "REVERSE"), ("+1", "−")])
def test_a_file_gives_what_its_numbers_give_whatever_the_order_and_the_signs(tmp_path, signs):
    lines = lines_of(signs=signs)
    random.Random(1).shuffle(lines)
    found = read(tmp_path, "# a comment\n" + HEADER + "\n" + "".join(lines), "utf-8-sig")
    assert found.up_um.tolist() == [list(x) for x in UP]
    assert found.down_um.tolist() == [list(x) for x in DOWN]
    assert found.both.accuracy == 8.0


@pytest.mark.parametrize(
    ("header", "convert"),
    [
        ("target,direction,run,deviation_mm", lambda t, d: (t, d / 1000)),
        ("target_mm,direction,run,position_mm", lambda t, d: (t, t + d / 1000)),
        ("target_mm,direction,run,position_um", lambda t, d: (t, 1000 * t + d)),
        ("target_in,direction,run,position_in", lambda t, d: (t / 25.4, (t + d / 1000) / 25.4)),
        ("target_in,direction,run,deviation_um", lambda t, d: (t / 25.4, d)),
    ],
)
def test_units_and_positions_are_understood_by_the_header(tmp_path, header, convert):
    text = header + "\n"
    for line in lines_of():
        target, sign, run, deviation = line.strip().split(",")
        at, value = convert(float(target), float(deviation))
        text += f"{at!r},{sign},{run},{value!r}\n"
    found = read(tmp_path, text)
    assert found.targets_mm == pytest.approx(TARGETS)
    assert np.concatenate([found.up_um, found.down_um]) == pytest.approx(np.concatenate([UP, DOWN]), abs=1e-6)


GOOD = lines_of()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "is empty"),
        (HEADER, "no rows of data"),
        ("target_mm,direction,deviation_um\n10,+,1\n", "row 1: the column 'run' is missing"),
        ("target_mm,direction,run\n10,+,1\n", "expected a column deviation_um"),
        ("target_mm,direction,run,deviation\n10,+,1,1\n", "'deviation' is not one of them"),
        ("place,direction,run,deviation_um\n10,+,1,1\n", "expected a column target"),
        ("target_mm;direction;run;deviation_um\n10;+;1;1\n", "is not separated by commas"),
        ("target_mm,direction,run,deviation_um,position_mm\n10,+,1,1,1\n", "say the same"),
        ("target_mm,target_mm,direction,run,deviation_um\n10,10,+,1,1\n", "say the same"),
        (HEADER + "10,+,1\n", "row 2: 3 cells"),
        (HEADER + "10,+,1,two\n", "row 2, column 'deviation_um': 'two' is not a number"),
        (HEADER + "# note\n10,+,1,nan\n", "row 3, column 'deviation_um': 'nan' is not a finite"),
        (HEADER + "10,x,1,2\n", "row 2, column 'direction': 'x' is no direction"),
        (HEADER + "10,+,1.5,2\n", "row 2, column 'run': '1.5' is not a whole number"),
        (HEADER + "10,+,1,200000\n", "is the unit right"),
        (HEADER + "".join(GOOD) + GOOD[3], "target 100 mm, direction +, run 1 stands in row 5 already"),
        (HEADER + "".join(GOOD[:-1]), "target 100 mm, direction -, run 3 is missing; every"),
        (HEADER + "".join(GOOD[:-2]), "target 100 mm, direction -, run 2 is missing, and 1 more"),
        (HEADER + "10,+,1,1\n100,+,1,2\n", "one run"),
        (HEADER + "10,+,1,1\n10,+,2,2\n", "one target"),
        (HEADER + '10,+,"1,2\n', "row 2"),
    ],
)
def test_a_broken_file_is_refused_by_row_and_column(tmp_path, text, said):
    with pytest.raises(DataError) as refused:
        read(tmp_path, text)
    assert said in str(refused.value)
    assert "test.csv" in str(refused.value)


def test_a_file_that_is_not_there_or_not_text_is_refused(tmp_path):
    with pytest.raises(DataError, match="cannot be read"):
        read_positioning(tmp_path / "nothing.csv")
    (tmp_path / "raw.csv").write_bytes(b"target_mm\xff\n")
    with pytest.raises(DataError, match="is not UTF-8 text"):
        read_positioning(tmp_path / "raw.csv")


def test_the_example_beside_the_code_is_the_made_one_and_says_so():
    file = Path(__file__).parents[2] / "examples" / "positioning.csv"
    assert file.read_text(encoding="utf-8") == example()
    assert "synthetic example, not a measurement" in example().splitlines()[0]
    found = read_positioning(file)
    assert found.runs == 5 and found.notes() == []
    # What its first lines say went in: 4.2 um of reversal, 0.02 um/mm and five runs' mean of 0.006 um/mm on 420.2 mm.
    assert found.both.mean_reversal == pytest.approx(-4.2, abs=0.3)
    slope = np.polyfit(found.targets_mm, found.both.mean, 1)[0]
    assert slope == pytest.approx(0.026, abs=0.004)
