"""The numbers on the page of the XY table are the study's."""

import re
from pathlib import Path

import pytest

from leadscrew.studies.npid_xytable.claims_comparison import measured
from leadscrew.studies.npid_xytable.results import Results
from tests.studies.whole import claims_of

PAGE = (Path(__file__).parents[2] / "docs" / "xy_table.md").read_text(encoding="utf-8")
ROWS = re.findall(r"\| `([a-z0-9_.]+)` \| ([\d.]+) \| ([\d.]+) \| ([\d.]+) \|", PAGE)


@pytest.fixture(scope="module")
def found():
    return Results()


def test_the_table_of_controllers_has_its_rows():
    assert len(ROWS) == 7 and ROWS[0][0] == "paper.pid"


@pytest.mark.slow
@pytest.mark.parametrize(("name", "rms", "rows", "drive"), ROWS)
def test_the_table_of_controllers(found, name, rms, rows, drive):
    now = measured(found.trials.nominal(name))
    assert [f"{now['rms']:.2f}", f"{abs(now['mean']):.1f}", f"{now['chatter']:.1f}"] == [rms, rows, drive]


@pytest.mark.slow
@pytest.mark.xdist_group("whole npid_xytable")
def test_what_is_said_beside_the_paper():
    m = {name: c.measured for name, c in claims_of("npid_xytable").items()}
    assert f"{m['random_mean_1']:.0f} % in the mean" in PAGE and m["random_worse_1"] == 0.0
    means = [f"{m['table2_mean_1000']:.2f}", *(f"{m[f'table2_mean_{rpm}']:.1f}" for rpm in (2000, 3000))]
    assert f"{means[0]}, {means[1]} and {means[2]} %" in PAGE
    assert f"K up to {m['sector_lc_popov_0']:.3f}" in PAGE and f"up to {m['sector_lc_popov_1']:.3f}" in PAGE
    assert f"{m['chatter_size_12']:.1f} um of it" in PAGE and f"up to {m['slope_at_e_max']:.2f}" in PAGE
    assert m["compute_time"] < 0.01 and f"by {m['m1_ours_pid_ms_159_least']:.0f} % of PID" in PAGE
    assert (
        f"lets {m['let_through_33_hz']:.1f} times" in PAGE and f"keeps {m['box_ours_resonant_full_rms']:.3f} um" in PAGE
    )
    page = " ".join(PAGE.split())
    assert f"at 1 mm {m['m4_rows']:.0f} % or more below" in page
    assert f"lines {m['m4_rows_no_spindle']:.0f} % are left" in page
    assert f"row is {-m['m4_rows_15mm']:.0f} % above" in page and f"{m['m4_rows_ff_15mm']:.0f} % below" in page
