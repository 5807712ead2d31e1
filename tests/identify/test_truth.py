"""The truth that fits are judged by, judged itself: against SciPy's integrator with events, and in what it promises."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.identify.axis_truth import PERIOD, SIDES, WELL, advance, laws, truths


def by_events(axis, push, speed):
    """Position and speed after each sample: `solve_ivp` between stops, rest where the push does not overcome it."""

    def after(x, v, u, left):
        while left > 1e-12:
            if v == 0.0 and -axis["s"][1] <= u <= axis["s"][0]:
                return x, v
            side = np.sign(v) if v != 0.0 else np.sign(u)
            i = 0 if side > 0.0 else 1
            c, s, vs, b = (axis[n][i] for n in ("c", "s", "vs", "b"))

            def rate(t, y, side=side, c=c, s=s, vs=vs, b=b):
                return [y[1], (u - side * (c + (s - c) * np.exp(-((y[1] / vs) ** 2))) - b * y[1]) / axis["mass"]]

            def stop(t, y, side=side):
                return side * y[1] if t > 0.0 else 1.0

            stop.terminal, stop.direction = True, -1  # type: ignore[attr-defined]
            run = solve_ivp(rate, (0.0, left), [x, v], events=stop, rtol=1e-9, atol=1e-13)
            x, v = run.y[0, -1], 0.0 if run.status == 1 else run.y[1, -1]
            left -= run.t[-1]
        return x, v

    x, v, rows = 0.0, speed, []
    for u in push:
        x, v = after(x, v, float(u), PERIOD)
        rows.append((x, v))
    return np.array(rows)


def test_axes_slide_stop_and_start_as_scipy_says():
    axis = {"mass": 20.0, "c": (8.0, 10.0), "s": (12.0, 11.0), "vs": (0.004, 0.01), "b": (30.0, 20.0)}
    t = np.arange(250) * PERIOD
    push = 14.0 * np.sin(2.0 * np.pi * 6.0 * t) - 1.0
    reference = by_events(axis, push, 0.02)
    p, x, v = laws([axis]), np.zeros(1), np.array([0.02])
    rows = []
    for u in push:
        for _ in range(10):
            x, v = advance(x, v, np.array([u]), np.array([PERIOD / 10]), p)
        rows.append((x[0], v[0]))
    ours = np.array(rows)
    at_rest = ours[:, 1] == 0.0
    assert 5 < at_rest.sum() < 200
    assert np.array_equal(at_rest, reference[:, 1] == 0.0)
    assert np.sign(ours[:, 1]).min() == -1.0 and np.sign(ours[:, 1]).max() == 1.0
    assert np.abs(ours[:, 0] - reference[:, 0]).max() < 1e-4 * np.ptp(reference[:, 0])
    assert np.abs(ours[:, 1] - reference[:, 1]).max() < 1e-3 * np.abs(reference[:, 1]).max()


@pytest.mark.slow
def test_an_axis_is_the_same_alone_and_in_company_and_its_steps_are_fine_enough():
    alone, company = truths((8,))[0], truths((3, 8))[1]
    assert np.array_equal(alone.position, company.position)
    assert np.array_equal(alone.drive, company.drive)
    # the same drive, played open loop with finer steps: the position does not move by more than rounding
    finer = truths((8,), None, 16)[0]
    assert np.abs(alone.position - finer.position).max() < 5.0 * alone.encoder_step


@pytest.mark.slow
def test_the_hundred_axes_are_what_they_are_said_to_be():
    axes = truths(tuple(range(100)))
    assert {t.kind.split("/")[0] for t in axes} == {"coulomb", "stribeck"}
    assert {t.symmetric for t in axes} == {True, False}
    assert {(t.position_unit, t.drive_unit) for t in axes} == {("m", "N"), ("rad", "N m"), ("m", "V")}
    assert sum(not t.excites for t in axes) == 10
    for t in axes:
        assert 12.0 <= len(t.time) * PERIOD <= 25.0 and np.isfinite(t.drive).all()
        steps = t.position / t.encoder_step
        assert np.abs(steps - np.round(steps)).max() < 1e-6
        assert np.abs(t.command - t.position).max() < 0.5 * np.ptp(t.command)
        if t.kind.endswith("one_way"):
            assert np.diff(t.command).min() > -1e-15
        if t.excites:
            assert t.excites == set(WELL)
            assert np.diff(t.command).min() < 0.0 < np.diff(t.command).max()
        for side in SIDES:
            assert t.values[f"friction.{side}.static"] >= t.values[f"friction.{side}.coulomb"] > 0.0
