"""The bench of many runs measures what it says."""

import pytest

from leadscrew.bench import PARTS, many
from leadscrew.bench.measuring import FIELDS


@pytest.mark.slow
def test_many_runs_give_rows_with_rate_and_memory():
    rows = many.rows(quick=True)
    assert "many runs" in PARTS and all(tuple(r) == FIELDS for r in rows)
    assert [r["unit"] for r in rows] == ["s", "MiB", "s", "MiB", "runs/s", "s"]
    assert all(r["value"] > 0 and r["passed"] is None for r in rows)
    assert all("load" in r["remark"] for r in rows if r["unit"] != "MiB")
