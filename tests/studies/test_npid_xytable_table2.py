"""Table II of the study as printed, what follows from it, and how well such amplitudes can be measured."""

import numpy as np
import pytest
from scipy.stats import ttest_rel

from leadscrew.studies.npid_xytable.measurement import by_fft, by_least_squares
from leadscrew.studies.npid_xytable.table2 import ROWS, at, base_hz, compared

PRINTED = """
1000 2.0 0.7865 0.4264 46 %    3.5 0.4205 0.7743 -46 %   5.0 0.7650 0.5321 30 %   6.3 0.7670 0.5446 29 %
     7.7 0.5239 0.6331 -17 %
2000 2.0 0.9456 0.3975 58 %    3.5 0.8731 0.6987 18 %    5.0 0.7412 0.5718 23 %   6.3 1.1800 0.6676 43 %
     7.7 1.3270 0.5319 60 %
3000 2.0 0.7870 0.2349 70 %    3.5 0.7276 0.7151 2 %     5.0 0.4130 0.4540 -9 %   6.3 0.2539 0.2831 -10 %
     7.7 0.2854 0.2048 28 %
"""
"""Typed a second time from the paper."""


def test_the_data_are_the_printed_table():
    cells = iter(PRINTED.replace("%", " ").split())
    for row in ROWS:
        if row.hz == 2.0:
            assert row.rpm == int(next(cells))
        assert (row.hz, row.pid_um, row.npid_um, row.printed) == tuple(float(next(cells)) for _ in range(4))
    assert next(cells, None) is None and len(ROWS) == 15


def test_the_wrong_percentages_are_found_by_hand_worked_numbers():
    wrong = {(r.rpm, r.hz) for r in ROWS if not r.agrees}
    assert wrong == {(1000, 3.5), (1000, 7.7), (2000, 3.5), (3000, 5.0), (3000, 6.3)}
    assert {(r.rpm, r.hz) for r in ROWS if r.wrong_base} == wrong - {(2000, 3.5)}
    # (0.4205 - 0.7743) / 0.4205 and over 0.7743.
    row = at(1000)[1]
    assert row.reduction == pytest.approx(-84.138, abs=1e-3) and row.against_npid == pytest.approx(-45.693, abs=1e-3)


def test_the_comparison_is_what_plain_formulas_give():
    found = compared(ROWS)
    pid, npid = np.array([[r.pid_um, r.npid_um] for r in ROWS]).T
    assert found.mean == pytest.approx(np.mean(100 * (pid - npid) / pid))
    assert found.geometric == pytest.approx(100 * (1 - np.prod(npid / pid) ** (1 / 15)))
    low, high = ttest_rel(np.log(npid), np.log(pid)).confidence_interval()
    assert (found.geometric_low, found.geometric_high) == pytest.approx(
        (100 * (1 - np.exp(high)), 100 * (1 - np.exp(low)))
    )
    assert found.t_test == pytest.approx(ttest_rel(pid, npid).pvalue, rel=1e-9) and found.worse == 4


def test_the_fundamental_of_the_printed_frequencies():
    # (3*2.0 + 5*3.5 + 7*5.0 + 9*6.3 + 11*7.7) / (9 + 25 + 49 + 81 + 121) = 199.9 / 285
    assert base_hz() == pytest.approx(199.9 / 285.0)


def test_a_plain_fft_misreads_what_least_squares_reads():
    assert np.max(np.abs(by_fft(8192, "rectangular"))) > 30.0
    assert np.max(np.abs(by_fft(16384, "hann"))) > 5.0
    assert np.max(np.abs(by_fft(8192, "flattop"))) < 0.05
    assert np.max(np.abs(by_least_squares(8192))) < 1e-9
