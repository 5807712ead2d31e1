"""Options of the form KEY=VALUE."""

import pytest

from leadscrew.cli import pairs
from leadscrew.util.errors import ValueRefused


def test_pairs_are_read_with_blanks_and_further_equals_signs():
    assert pairs.texts("--x", ["a = 1", "b=c=d"], "KEY=VALUE") == {"a": "1", "b": "c=d"}
    assert pairs.values("--x", ["a=1e-3", "b=-2"], "KEY=NUMBER") == {"a": 1e-3, "b": -2.0}
    assert pairs.texts("--x", None, "KEY=VALUE") == {}


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (["a=1", "a=2"], "--x a: given twice"),
        (["a"], "--x 'a': expected KEY=NUMBER"),
        (["=1"], "--x '=1': expected KEY=NUMBER"),
        (["a="], "--x 'a=': expected KEY=NUMBER"),
        (["a=nan"], "--x a=nan: expected a number behind the ="),
        (["a=-inf"], "--x a=-inf: expected a number behind the ="),
        (["a=1 mm"], "--x a=1 mm: expected a number behind the ="),
    ],
)
def test_a_pair_that_is_none_is_refused_by_option_and_key(given, said):
    with pytest.raises(ValueRefused) as seen:
        pairs.values("--x", given, "KEY=NUMBER")
    assert str(seen.value) == said
