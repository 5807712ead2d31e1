"""A force loop that needs no study: feed servo, filtered and noisy force, 20 ms. Linear, so that SciPy knows it too."""

from typing import NamedTuple

from leadscrew.controllers._grey_fuzzy.smith import smith
from leadscrew.kernel.block import sensor
from leadscrew.kernel.loop import Loop
from leadscrew.kernel.noise import normal
from leadscrew.plants._linear import transfer_function
from leadscrew.references._step import step
from leadscrew.studies.grey_turning.tunings import TUNINGS

GAIN, RATE, DAMPING, KEEP = 488.0, 40.0, 0.7, 0.8
FEED = transfer_function([GAIN * RATE**2], [1.0, 2.0 * DAMPING * RATE, RATE**2])


class Cell(NamedTuple):
    keep: float = KEEP
    noise_n: float = 2.0


class Filtered(NamedTuple):
    force: float = 0.0


@sensor(Cell(), Filtered(), unit="N")
def cell(p, s, actual, noise):
    force = p.keep * s.force + (1.0 - p.keep) * (actual + p.noise_n * normal(noise, 0))
    return Filtered(force), force


def force_loop(controller, noise=2.0, target=150.0, **more):
    return Loop(
        reference=step(target=target),
        controller=controller,
        plant=FEED,
        sensor=cell(noise_n=noise),
        period=0.02,
        substeps=4,
        metrics={},
        **more,
    )


def traditional():
    return force_loop(TUNINGS["corrected.tfc_stfc"])


def grey():
    """Reading B, raw GM(1,1): the start-up uses the exponentials."""
    return force_loop(TUNINGS["ours.gm_raw_stfc"])


def grey_smallest():
    """Reading A with the minimum."""
    return force_loop(TUNINGS["corrected.gpfc_a_s9_half"](inference=1, horizon=2.0))


def proportional():
    return force_loop(TUNINGS["ours.pi_stfc"])


def with_a_model():
    return force_loop(smith)
