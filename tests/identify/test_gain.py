"""The plant gain from logs: a plant of known gain gives it back, Table 1 gives those of an independent fit."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from leadscrew.identify.linear.servo_gain import Record, fit_gain
from leadscrew.studies.vud_lathe.laws import gain_fits, moves
from leadscrew.util.errors import DataError, ValueRefused

LAGS = (0.0008, 0.0015, 0.017)
TIME = np.arange(21) * 0.1
DUTY = np.exp(-3 * TIME) * (TIME > 0)


def integrated(gain, between):
    """Position of the chain by an adaptive integrator, with the input between samples as given."""

    def rates(t, x):
        return [(between(t) - x[0]) / LAGS[0], (x[0] - x[1]) / LAGS[1], (x[1] - x[2]) / LAGS[2], gain * x[2]]

    return solve_ivp(rates, (0, 2), [0, 0, 0, 0], t_eval=TIME, method="LSODA", rtol=1e-9, atol=1e-10, max_step=0.01).y[
        3
    ]


@pytest.mark.parametrize(
    ("hold", "between"),
    [
        ("linear", lambda t: np.interp(t, TIME, DUTY)),
        ("previous", lambda t: DUTY[min(int(t / 0.1 + 1e-12), 20)]),
        ("current", lambda t: DUTY[min(int(t / 0.1 + 1e-12) + 1, 20)]),
    ],
)
def test_a_plant_of_known_gain_gives_it_back(hold, between):
    fit = fit_gain({"run": Record(TIME, DUTY, integrated(-289.0, between))}, LAGS, hold)
    assert fit.gain == pytest.approx(-289.0, rel=2e-5)
    assert fit.nrmse_percent["run"] < 0.01


def test_table_1_gives_288_8_mm_s_and_the_misfit_of_each_move():
    fits = gain_fits(moves())
    main = fits["linear"]
    assert -main.gain == pytest.approx(288.8, abs=0.5)
    assert list(main.nrmse_percent.values()) == pytest.approx([1.45, 12.5, 14.2, 1.41], abs=0.1)
    assert [-g for g in main.gain_alone.values()] == pytest.approx([285.8, 333.3, 341.2, 286.1], abs=0.3)
    assert [-fits[h].gain for h in ("previous", "current")] == pytest.approx([293.9, 283.3], abs=0.3)
    assert main.spread_percent == pytest.approx(19.2, abs=0.5)


def test_logs_that_cannot_tell_a_gain_are_refused_by_name():
    still, dead = np.zeros(21), Record(TIME, np.zeros(21), np.ones(21) * TIME)
    for record, says in (
        (dead, "never acts"),
        (Record(TIME, DUTY, still), "never moves"),
        (Record(TIME[:2], DUTY[:2], TIME[:2]), "at least three"),
        (Record(TIME**2, DUTY, TIME), "not evenly"),
        (Record(TIME, DUTY[:-1], TIME), "21, 20, 21"),
    ):
        with pytest.raises(DataError, match=f"record bad: .*{says}"):
            fit_gain({"bad": record}, LAGS)
    with pytest.raises(DataError, match="no records"):
        fit_gain({}, LAGS)
    with pytest.raises(ValueRefused, match="linear, previous, current"):
        fit_gain({"run": Record(TIME, DUTY, TIME)}, LAGS, "guess")
    with pytest.raises(ValueRefused, match="above 0 s"):
        fit_gain({"run": Record(TIME, DUTY, TIME)}, (0.0,))


def test_the_last_digits_of_a_gain_do_not_change_with_the_threads_of_the_linear_algebra():
    import scipy.linalg  # noqa: F401  its BLAS has threads of its own
    from threadpoolctl import threadpool_limits

    u = np.random.default_rng(0).normal(size=11_000)
    record, found = Record(np.arange(11_000) / 2000.0, u, np.cumsum(u) / 2000.0), []
    for threads in (1, 4):
        with threadpool_limits(threads):
            fit = fit_gain({"run": record}, (), "linear")
            found.append((fit.gain, fit.nrmse_percent["run"]))
    assert len(set(found)) == 1
