"""The numbers of an experiment file, at the ends of their ranges."""

import math

import pytest

from leadscrew.experiment_file import validated
from leadscrew.util.errors import DataError

HEAD = {"schema_version": 1, "study": "vud_lathe"}


@pytest.mark.parametrize(
    ("key", "good", "bad"),
    [
        ("replicate", (0, 2**31 - 1), (-1, 2**31, 1.0)),
        ("seed", (0, 2**62), (-1, 0.5)),
        ("every", (1, 1000), (0, -1, 2.5)),
        ("duration", (1e-9, 3.5), (0.0, -1.0, math.inf, math.nan, "1")),
        ("schema_version", (1, 2), (3, "1")),
        ("study", ("x",), ("", 3)),
    ],
)
def test_a_number_out_of_range_is_refused_by_file_and_key(key, good, bad):
    for value in good:
        validated({**HEAD, key: value}, "e.toml")
    for value in bad:
        with pytest.raises(DataError, match=rf"e\.toml: {key} = "):
            validated({**HEAD, key: value}, "e.toml")


def test_tables_of_changes_become_dotted_keys_and_an_unknown_key_gets_a_suggestion():
    found = validated({**HEAD, "set": {"plant": {"motor": {"r": 1.0}}, "seed": 2}}, "e.toml")
    assert found["changes"] == {"plant.motor.r": 1.0, "seed": 2}
    with pytest.raises(DataError, match=r"e\.toml: there is no key 'scenari'; did you mean scenario"):
        validated({**HEAD, "scenari": "x"}, "e.toml")
