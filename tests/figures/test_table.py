"""Numbers and units as a reader meets them in tables."""

import math

import pytest

from leadscrew.figures.table import Table, header, number, unit


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.25178608, "0.2518"), (37221.848, "37,222"), (-0.129, "−0.129"), (8.7e-05, "8.7e-05"), (36.0, "36"),
        (math.inf, "never"), (math.nan, "–"), (None, "–"), (True, "yes"), ("PB", "PB"), (1234.6, "1,235"), (0.0, "0"),
    ],
)  # fmt: skip
def test_a_number_has_four_digits_and_a_true_minus(value, text):
    assert number(value) == text


def test_units_are_printed_as_the_field_writes_them():
    assert [header(h) for h in ("error (um)", "duty (1)", "gain (rad/(s V))", "law")] == [
        "error (µm)", "duty", "gain (rad/(s·V))", "law",
    ]  # fmt: skip
    assert unit("N m") == "N·m" and unit("mm/s") == "mm/s"


def test_a_row_of_another_length_is_refused_and_names_itself():
    with pytest.raises(ValueError, match="row 'a': 1 values for 2 columns"):
        Table("law", ("x", "y"), {"a": (1.0,)})
    table = Table("law", ("x (um)", "rule"), {"a": (1.0, "PB"), "b": (None, "PM")})
    assert table.numeric() == [False, True, False] and table.cells()[1] == ["b", "–", "PM"]
