"""A made-up identified axis, by hand: what a fit of a stage of 20 kg with unlike friction would hold."""

from dataclasses import replace

import numpy as np

from leadscrew.identify.axis.result import AxisFit, Judged
from leadscrew.identify.estimation import Parameter

PERIOD = 1e-3
KEYS = ("mass", "offset", "friction.forward.coulomb", "friction.backward.coulomb", "friction.forward.viscous",
        "friction.backward.viscous")  # fmt: skip


def stretch(what="hold-out", start=5.0, rms=2e-5, colour=0.0, seed=1, samples=5000):
    """Five seconds of a sine; the residual force is noise, of which each sample keeps ``colour`` of the one before."""
    rng = np.random.default_rng(seed)
    time = start + PERIOD * np.arange(samples)
    measured = 0.1 * np.sin(2.0 * np.pi * 0.4 * time)
    speed = 0.1 * 2.0 * np.pi * 0.4 * np.cos(2.0 * np.pi * 0.4 * time)
    noise = rng.normal(0.0, 0.8, len(time))
    for k in range(1, len(noise)):
        noise[k] += colour * noise[k - 1]
    error = rms * np.sqrt(2.0) * np.sin(2.0 * np.pi * 0.11 * (time - start))
    return Judged(
        what, start, float(time[-1]), rms, 1.4 * rms, 100.0 * rms / 0.2, float(noise.std()),
        100.0 * float(noise.std()) / 30.0, 94.0, time, measured, measured - error, speed, noise,
    )  # fmt: skip


def made_up(**changes) -> AxisFit:
    """The fit; ``changes`` are fields of it."""
    fitted = {
        "mass": Parameter(20.0, "kg", 19.9, 20.1, "fitted", True),
        "offset": Parameter(-1.5, "N", -1.7, -1.3, "fitted", True),
        "friction.forward.coulomb": Parameter(18.0, "N", 17.8, 18.2, "fitted", True),
        "friction.backward.coulomb": Parameter(22.0, "N", 21.7, 22.3, "fitted", True),
        "friction.forward.viscous": Parameter(60.0, "N s/m", 58.0, 62.0, "fitted", True),
        "friction.backward.viscous": Parameter(55.0, "N s/m", -10.0, 120.0, "fitted", False, "it never moves fast"),
        "force_per_drive": Parameter(35.0, "N/V", np.nan, np.nan, "given", True),
        "backlash": Parameter(0.0, "m", np.nan, np.nan, "fixed", False, "one encoder cannot see lost motion"),
        "delay_s": Parameter(1e-3, "s", np.nan, np.nan, "fitted", True),
    }
    correlation = {a: {b: 1.0 if a == b else 0.0 for b in KEYS} for a in KEYS}
    whole = AxisFit(
        "bench/stage.csv", "coulomb", False, "m", "V", PERIOD, fitted,
        [stretch("training", 0.0, 1.6e-5, seed=2), stretch(), stretch("whole log, closed loop", 0.0, 2e-7)],
        12.5, correlation, "inverse dynamics with a filter of 40 Hz, refined by simulation over windows of 1 s",
        1e-6, 3e-7, 0.25, 0.63, (-0.1, 0.1), 4.0,
        notes=["the drive stands at its limit in 3 samples"], advice=["move faster backwards"],
        missing=("friction.backward.viscous", "backlash"),
        compared=[{"model": "coulomb", "holdout_rms": 2e-5, "against": ""},
                  {"model": "stribeck", "holdout_rms": 3.1e-5, "against": "no better on the hold-out"}],
    )  # fmt: skip
    return replace(whole, **changes)


def alike(**changes) -> AxisFit:
    """The same with friction alike both ways."""
    found = made_up()
    both = {}
    for key, p in found.parameters.items():
        twin = found.parameters[key.replace(".backward.", ".forward.")]
        both[key] = twin if ".backward." in key else p
    return replace(found, symmetric=True, parameters=both, **changes)
