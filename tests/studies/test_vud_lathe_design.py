"""Rules, units and curvature from Table 1, and the circuit of Figure 5: the study's claims against second methods."""

import numpy as np
import pytest
from scipy import signal

from leadscrew.controllers._vud.universe import TABLE_2
from leadscrew.studies.vud_lathe import curvature as circuit
from leadscrew.studies.vud_lathe import curvature as trials
from leadscrew.studies.vud_lathe.laws import learn, moves


def test_covered_cells_and_conflicts_are_those_of_a_count_by_hand():
    """The table's rows put into cells by comparing distances to the centres, nothing of ours in between."""
    centres = np.array([-1.0, -0.67, -0.33, 0.33, 0.67, 1.0])
    cells: dict = {}
    for move in moves().values():
        for e, ec, rho in zip(move.error[1:], move.rate[1:], move.duty[1:], strict=True):
            if 0.0 in (e, ec, rho):
                continue
            near = [np.abs(centres - x) for x in (e, ec, rho)]
            width = {0: 0.33, 1: 0.34, 2: 0.66, 3: 0.34, 4: 0.33}
            mu = [1.0 - d.min() / width[int(np.searchsorted(centres, x, side="right").clip(1, 5)) - 1]
                  for d, x in zip(near, (e, ec, rho), strict=True)]  # fmt: skip
            i, j, k = (int(d.argmin()) for d in near)
            cells.setdefault((i, j), {}).setdefault(k, []).append(float(np.prod(mu)))
    winners = {at: max(out, key=lambda k: max(out[k])) for at, out in cells.items()}
    agree = sum(np.sign(centres[k]) == np.sign(TABLE_2[at]) and abs(centres[k] - TABLE_2[at]) < 0.01
                for at, k in winners.items())  # fmt: skip
    learned = learn(moves())
    assert len(cells) == learned.covered == 8
    assert sum(len(out) > 1 for out in cells.values()) == len(learned.conflicts) == 4
    assert agree == learned.agreement(TABLE_2)[0] == 6
    assert max(cells[1, 5][4]) == pytest.approx(learned.cells[1, 5].winner.strength)


def test_an_odd_polynomial_is_the_one_of_odd_powers_alone():
    """The mirrored fit against a plain least-squares fit of odd monomials, differentiated by hand."""
    points, duty = trials.table_1(moves())
    e, c = points.T
    weights = np.linalg.lstsq(np.column_stack([e, c, e**3, e**2 * c, e * c**2, c**3]), duty, rcond=None)[0]
    assert trials.polynomial(trials.table_1(moves()), 3)[0][0] == pytest.approx(
        np.abs(6 * weights[2] * e + 2 * weights[3] * c).max()
    )
    assert trials.polynomial(trials.table_1(moves()), 3)[0][1] == pytest.approx(
        np.abs(2 * weights[4] * e + 6 * weights[5] * c).max()
    )


def test_local_fits_are_exact_on_a_quadratic():
    samples = trials.scattered()
    e, c = samples.points.T
    bent = trials.Samples(samples.points, 0.7 * e**2 - 0.4 * c**2 + 0.3 * e * c - e)
    assert trials.local(bent, 0.3) == pytest.approx((1.4, 0.8))


def test_the_known_law_has_the_curvatures_that_it_is_said_to_have():
    h, e, c = 1e-4, -1.0, 1.0
    bend_e = (trials.law(e + h, c) - 2 * trials.law(e, c) + trials.law(e - h, c)) / h**2
    bend_c = (trials.law(e, c + h) - 2 * trials.law(e, c) + trials.law(e, c - h)) / h**2
    assert (abs(bend_e), abs(bend_c)) == pytest.approx(trials.TRUE, abs=1e-5)


# ---- Figure 5
def test_two_stages_are_s_squared_over_the_lags_as_scipy_simulates_it():
    time = np.arange(3000) * 0.0005
    x = np.sin(7.0 * time) ** 2 + 0.2 * time**2
    lag = 0.02
    _, expected, _ = signal.lsim(([1.0, 0.0, 0.0], [lag**2, 2.0 * lag, 1.0]), x, time)
    found = circuit.differentiate(x, lag, dt=0.0005)
    assert found[200:] == pytest.approx(expected[200:], abs=0.01 * np.abs(expected).max())


def test_the_circuit_s_low_frequencies_are_the_second_derivative():
    time = np.arange(20000) * 0.001
    found = circuit.differentiate(np.sin(time), 0.002)
    assert found[2000:] == pytest.approx(-np.sin(time[2000:]), abs=0.01)


def test_of_a_straight_law_the_circuit_reads_the_slope_and_of_a_power_law_no_curvature():
    run = circuit.step_run(-190.0)
    straight = circuit.scope(run.time, run.e, run.ec, -0.929 * run.e).over_e[100:]
    assert straight == pytest.approx(0.929)


def test_curvature_of_our_stand_in_is_its_second_difference():
    h, e = 1e-4, 0.3

    def law(x):
        return 0.929 * x**0.618

    assert circuit.power_curvature(-e, 0.929, 0.618) == pytest.approx(
        abs(law(e + h) - 2 * law(e) + law(e - h)) / h**2, rel=1e-5
    )
