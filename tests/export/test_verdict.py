"""The verdict on an export, bit by bit, and golden vectors that lose none."""

import math

import numpy as np
import pytest

from leadscrew.export.core import Record
from leadscrew.export.verdict import DIFFERENT, FAILED, GOLDEN, IDENTICAL, compared, golden_text, read_golden
from leadscrew.util.errors import DataError
from tests.export import hal_sample

ULP = math.ulp(1.0)


@pytest.mark.parametrize(
    ("got", "verdict", "worst"),
    [
        ([1.0, -2.0, math.nan, 0.0], IDENTICAL, 0.0),
        ([1.0, -2.0, -math.nan, 0.0], IDENTICAL, 0.0),
        ([1.0 + ULP, -2.0, math.nan, 0.0], DIFFERENT, ULP),
        ([1.0, -3.5, math.nan, 0.25], DIFFERENT, 1.5),
        ([1.0, -2.0, math.nan, -0.0], DIFFERENT, 0.0),
    ],
)
def test_outputs_are_identical_in_every_bit_or_by_how_much_they_are_not(got, verdict, worst):
    expected = np.array([[1.0, -2.0, math.nan, 0.0]]).T
    found = compared("c99", expected, np.array([got]).T, "gcc 12")
    assert (found.verdict, found.cycles, found.worst, found.note) == (verdict, 4, worst, "gcc 12")


def test_rows_that_did_not_come_back_fail_the_export():
    found = compared("c99", np.zeros((4, 1)), np.zeros((3, 1)))
    assert (found.verdict, found.worst, found.note) == (FAILED, None, "3 rows came back, 4 were expected")


def test_golden_vectors_come_back_with_every_bit(tmp_path):
    numbers = np.random.default_rng(1).normal(size=(50, 4)) * 10.0 ** np.arange(-200, 200, 8)[:, None]
    numbers[0] = 5e-324, -0.0, 0.1 + 0.2, 1.7976931348623157e308
    text = golden_text(hal_sample.core("axis"), Record(numbers[:, :3], numbers[:, 3:]))
    (tmp_path / GOLDEN).write_text(text)
    names, rows = read_golden(tmp_path / GOLDEN)
    assert names == ["command", "command_velocity", "feedback", "output"]
    np.testing.assert_array_equal(rows.view(np.int64), numbers.view(np.int64))
    (tmp_path / GOLDEN).write_text(text.replace("command,", ""))
    with pytest.raises(DataError, match=r"golden\.csv: not a table of golden vectors"):
        read_golden(tmp_path / GOLDEN)
