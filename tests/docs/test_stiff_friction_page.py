"""The tables of the page on stiff friction hold what the schemes do now."""

import math
from pathlib import Path

import numpy as np
import pytest

from leadscrew.controllers.sliding.complementary import csmc
from leadscrew.controllers.sliding.conventional import smc
from leadscrew.plants.ballscrew_stage import TRAVEL_MM_PER_RAD
from leadscrew.studies.fsmc_ballscrew.integrators import (
    NM,
    PERIOD_S,
    SMOOTH,
    TRUTH,
    angles,
    error_nm,
    every,
    rodas,
    sharp_pd,
    soft_pd,
)

PAGE = Path(__file__).parents[2] / "docs" / "stiff_friction.md"


def table(name):
    """Cells of the rows of the table below a mark."""
    after = PAGE.read_text(encoding="utf-8").split(f"<!-- checked: {name} -->")[1].strip().split("\n\n")[0]
    return [[c.strip() for c in line.strip("|").split("|")] for line in after.splitlines()[2:]]


def scheme(said):
    """The scheme of a row's name."""
    method, number = said.split()[:2]
    return rodas(float(number)) if method == "rodas" else every(method, float(number))


@pytest.mark.slow
def test_each_scheme_errs_as_much_as_the_table_says():
    truth = {(s, law): angles(s, TRUTH, law=law) for law in (soft_pd, sharp_pd) for s in SMOOTH}
    rows = table("errors")
    assert len(rows) == 10
    for name, *cells in rows:
        for (sine, law), said in zip(truth, cells, strict=True):
            found = error_nm(sine, scheme(name), truth[sine, law], law=law)
            if said == "diverges":
                assert not found < 1e6, name
            elif float(said) < 1e-4:  # what is left of rounding: another machine rounds the same, but let it be said
                assert found < 2e-5, name
            else:
                assert float(f"{found:.3g}") == float(said), (name, sine)


@pytest.mark.slow
@pytest.mark.parametrize(("column", "law"), [(1, smc), (2, csmc)])
def test_stick_slip_runs_differ_by_what_the_table_says(column, law):
    truth = angles("sine_slow", rodas(1e-12), law=law)
    said = {float(row[0]): float(row[column]) for row in table("slips")}
    found = {r: float(NM * np.abs(angles("sine_slow", rodas(r), law=law) - truth).max()) for r in said}
    for rtol, value in said.items():
        assert found[rtol] == pytest.approx(value, rel=0.01), rtol
    assert found[1e-3] > 50.0
    assert found[1e-9] < 0.2


@pytest.mark.slow
def test_statistics_of_a_stick_slip_run_agree_where_its_points_do_not():
    truth = angles("sine_slow", rodas(1e-12), law=smc)
    command = 0.01 / TRAVEL_MM_PER_RAD * np.sin(PERIOD_S * np.arange(len(truth)))

    def statistics(run):
        e = 1e-3 * NM * (run - command)
        return np.abs(e).max(), math.sqrt(np.mean(e * e))

    expected = statistics(truth)
    assert expected == pytest.approx((21.74, 14.55), abs=0.005)
    late = angles("sine_slow", every("fixed", 50.0), law=smc)
    assert NM * np.abs(late - truth).max() == pytest.approx(5800.0, rel=0.01)
    for run in (late, angles("sine_slow", rodas(1e-3), law=smc)):
        assert statistics(run) == pytest.approx(expected, rel=1e-3)
