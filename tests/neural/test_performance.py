"""The performance measurement: the paper's table and what is read from it, the network, inside a block too."""

import math
from typing import NamedTuple

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator

from leadscrew import Loop, controller, plant
from leadscrew.neural.performance import (
    BILINEAR,
    GOLDEN,
    LEVELS,
    NETWORK,
    ODD,
    ODD_TABLE,
    ROUNDED,
    TABLE,
    Performance,
    correction,
    looked_up,
    looked_up_rounded,
    measured,
    net_text,
    read_net,
    read_table,
    write_net,
)
from leadscrew.references._step import step
from leadscrew.util.errors import DataError
from tests.fuzzy.formats_systems import shared
from tests.tools import runnable

PAPER = """
-6 6 6 6 6 5 5 0 0 0 0 0 0 0
-5 6 6 6 5 4 4 0 0 0 0 0 0 0
-4 6 6 5 4 3 2 0 0 0 0 0 0 0
-3 6 6 5 4 3 2 0 0 0 -2 -2 -2 0
-2 6 6 5 4 1 1 0 0 0 -2 -4 -2 0
-1 5 5 4 3 2 1 0 0 0 -3 -5 -3 0
0 4 3 3 3 2 1 0 -1 -2 -4 -4 -6 -6
1 2 3 4 3 0 0 0 -1 -2 -4 -6 -6 -6
2 0 2 3 2 0 0 0 -1 -2 -4 -6 -6 -6
3 0 2 2 2 0 0 0 -2 -3 -4 -6 -6 -6
4 0 0 0 0 0 0 0 -3 -4 -5 -6 -6 -6
5 0 0 0 0 0 0 0 -4 -5 -5 -6 -6 -6
6 0 0 0 0 0 0 0 -5 -6 -6 -6 -6 -6
"""
"""Table 1, typed off the paper: EC, then P at E = -6 ... 6."""
POINTS = [(e, ec) for e in np.linspace(-7.3, 7.1, 19) for ec in np.linspace(-8.0, 6.9, 17)]


def test_the_table_is_the_papers_cell_by_cell():
    rows = [[float(cell) for cell in line.split()] for line in PAPER.strip().splitlines()]
    assert [row[0] for row in rows] == LEVELS.tolist()
    assert np.array_equal(TABLE, [row[1:] for row in rows])


def test_the_table_is_that_of_the_papers_text():
    text = shared("papers/text/sofnn_tangent.txt").read_text(encoding="utf-8")
    lines = [line.split("\t") for line in text.splitlines()]
    rows = [row for row in lines if len(row) == 14 and row[0].lstrip("-").isdigit()]
    assert np.array_equal(TABLE, [[float(cell) for cell in row[1:]] for row in rows])


def test_nobody_can_change_the_shipped_table():
    with pytest.raises(ValueError, match="read-only"):
        TABLE[0, 0] = 1.0


def test_between_the_cells_the_table_is_bilinear_and_outside_it_is_held():
    other = RegularGridInterpolator((LEVELS, LEVELS), TABLE)
    for e, ec in POINTS:
        inside = [np.clip(ec, -6.0, 6.0), np.clip(e, -6.0, 6.0)]
        assert looked_up(TABLE, e, ec) == pytest.approx(other(inside)[0], abs=1e-12)


@pytest.mark.parametrize(("e", "ec", "p"), [(0.49, 0.0, 0.0), (-0.49, 3.0, 0.0), (0.51, 0.0, -1.0), (-4.4, 2.4, 3.0),
                                            (0.5, 0.0, 0.0), (99.0, -99.0, 0.0), (99.0, 99.0, -6.0)])  # fmt: skip
def test_rounded_the_nearest_cell_counts_and_half_a_level_is_nothing(e, ec, p):
    assert looked_up_rounded(TABLE, e, ec) == p


def test_the_odd_table_is_odd_and_half_of_what_it_differs_by():
    assert np.array_equal(ODD_TABLE, -ODD_TABLE[::-1, ::-1])
    assert ODD_TABLE[6, 11] == -4.5  # (-6 - 3) / 2, the pair that cancels least


def by_hand(net, e, ec):
    x, y = np.clip(e, -6, 6) / 6.0, np.clip(ec, -6, 6) / 6.0
    total = net.out_bias
    for (a, b), c, v in zip(net.hidden, net.hidden_bias, net.out, strict=True):
        total += v * math.tanh(a * x + b * y + c)
    return min(max(total, -6.0), 6.0) if net.linear else 6.0 * math.tanh(total)


@pytest.mark.parametrize("linear", [False, True])
def test_the_network_is_its_equation(linear):
    draw = np.random.default_rng(3)
    net = Performance(draw.normal(size=(4, 2)), draw.normal(size=4), 3.0 * draw.normal(size=4), 0.3, linear)
    for e, ec in POINTS:
        assert measured(net, e, ec) == pytest.approx(by_hand(net, e, ec), abs=1e-12)


def test_the_golden_network_answers_the_papers_three_areas():
    """2.71, -2.63, -0.56 levels."""
    assert [round(measured(GOLDEN, e, ec), 2) for e, ec in ((-4, 2), (2, 2), (2, -2))] == [2.71, -2.63, -0.56]
    assert measured(GOLDEN, 0.0, 0.0) == 0.0


class TryParams(NamedTuple):
    kind: int = 0
    table: np.ndarray = TABLE
    net: Performance = GOLDEN


class TryState(NamedTuple):
    k: int = 0


@controller(TryParams(), TryState())
def trying(p, s, command, feedback):
    return TryState(s.k + 1), correction(p.kind, p.table, p.net, -9.0 + 0.37 * (s.k % 50), -9.0 + 0.41 * (s.k // 50))


class Still(NamedTuple):
    x: float = 0.0


@plant(None, Still())
def still(s, u):
    return Still(0.0)


@pytest.mark.parametrize("engine", ["python", "c"])
def test_every_source_gives_the_same_in_a_compiled_loop(engine):
    loop = Loop(reference=step(target=0.0), controller=trying, plant=still, metrics={})
    places = [(-9.0 + 0.37 * (k % 50), -9.0 + 0.41 * (k // 50)) for k in range(2000)]
    for kind in (BILINEAR, ROUNDED, NETWORK, ODD):
        run = loop.using({"controller.kind": kind}).run(2.0, engine=runnable(engine))
        wanted = [correction(kind, TABLE, GOLDEN, e, ec) for e, ec in places]
        assert run["output"] == pytest.approx(wanted, abs=1e-13)


def test_a_network_comes_back_from_its_file_to_the_last_bit(tmp_path):
    draw = np.random.default_rng(1)
    net = Performance(draw.normal(size=(3, 2)), draw.normal(size=3), draw.normal(size=3), 1.0 / 3.0, True)
    write_net(net, tmp_path / "net.json", {"seed": 1})
    back = read_net(tmp_path / "net.json")
    assert all(np.array_equal(a, b) for a, b in zip(net, back, strict=True))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[1, 2]", "holds no JSON object"),
        ("{", "is not JSON"),
        (net_text(GOLDEN).replace('"version": 1', '"version": 7'), "has version 7"),
        (net_text(GOLDEN).replace('"out":', '"outs":'), "'out' is missing"),
        (net_text(GOLDEN).replace("6.735155", "NaN"), "not finite"),
        (net_text(GOLDEN).replace("6.735155", '"x"'), "does not hold numbers"),
        (net_text(GOLDEN).replace("6.735155, ", ""), r"expected \(5, 2\), \(5,\)"),
        (net_text(GOLDEN).replace('"linear": false', '"linear": 2'), "expected true or false"),
    ],
)
def test_a_bad_network_file_is_refused_in_a_sentence(tmp_path, text, said):
    (tmp_path / "net.json").write_text(text, encoding="utf-8")
    with pytest.raises(DataError, match=said):
        read_net(tmp_path / "net.json")


def test_a_missing_network_file_is_refused(tmp_path):
    with pytest.raises(DataError, match="cannot be read"):
        read_net(tmp_path / "none.json")


def text_of(table, around=True):
    rows = [",".join(f"{v:g}" for v in row) for row in table]
    if not around:
        return "\n".join(rows) + "\n"
    head = "EC\\E," + ",".join(f"{v:g}" for v in LEVELS)
    return "\n".join([head, *(f"{ec:g},{row}" for ec, row in zip(LEVELS, rows, strict=True))]) + "\n"


@pytest.mark.parametrize("around", [True, False])
def test_a_table_is_read_with_and_without_its_levels(tmp_path, around):
    (tmp_path / "table.csv").write_text("# ours\n" + text_of(0.5 * TABLE, around), encoding="utf-8")
    assert np.array_equal(read_table(tmp_path / "table.csv"), 0.5 * TABLE)


GOOD = text_of(TABLE, around=False)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (GOOD.split("\n", 1)[1], "12 lines; expected 13 lines of 13"),
        (GOOD.replace("6,6,6,6,5,5,0,0,0,0,0,0,0", "6,6,6,6,5,5,0,0,0,0,0,0", 1), "row 1: 12 numbers"),
        (GOOD.replace("-3,-5,-3", "-3,x,-3"), r"row 6, column 'E = 4': 'x' is not a number"),
        (GOOD.replace("-3,-5,-3", "-3,-7,-3"), r"row 6, column 'E = 4': -7 is outside -6 to 6"),
        (GOOD.replace("-3,-5,-3", "-3,nan,-3"), "not a finite number"),
        (text_of(TABLE).replace("-6,-5,-4", "-6,-4,-5", 1), "levels of E are -6, -4"),
        (text_of(TABLE).replace("\n6,", "\n7,"), "levels of EC are"),
        ("", "is empty"),
    ],
)
def test_a_bad_table_is_refused_with_its_row(tmp_path, text, said):
    (tmp_path / "table.csv").write_text(text, encoding="utf-8")
    with pytest.raises(DataError, match=said):
        read_table(tmp_path / "table.csv")
