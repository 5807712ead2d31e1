"""Self-tuning of the friction feed-forward in the study: its claims, and other machines than the nominal one."""

import pytest

from leadscrew.studies.fsmc_ballscrew.controllers import CONTROLLERS
from leadscrew.studies.fsmc_ballscrew.runs import Loops, tail_um
from leadscrew.studies.fsmc_ballscrew.selftuned import believing, identified, rounded
from leadscrew.studies.fsmc_ballscrew.tunings import GAINS


@pytest.mark.slow
def test_after_a_change_of_friction_a_new_record_brings_the_error_back():
    loops = Loops()
    harder = {"plant.friction.coulomb": 1.2 * 6.24, "plant.friction.static": 1.2 * 9.36}
    before = believing(CONTROLLERS["ours.pd_dob"], identified(loops, "sines"), GAINS)
    after = believing(CONTROLLERS["ours.pd_dob"], identified(loops, "sines", changes=harder), GAINS)
    old, new = (tail_um(loops.run(law, "sine_fast", 3.0, changes=harder), 0.15)[0] for law in (before, after))
    assert old > 0.4 and new < 0.25 * old


@pytest.mark.slow
def test_on_friction_that_is_not_lugre_the_fit_says_so():
    fit = identified(Loops(), "test", "gms")
    assert not fit.consistent
    assert abs(fit.friction.coulomb / 6.24 - 1.0) < 1e-3 and abs(fit.friction.viscous / 0.4 - 1.0) < 1e-3


@pytest.mark.slow
def test_three_digits_are_what_a_controller_gets():
    fit = identified(Loops(), "sines")
    short = rounded(fit)
    law = believing(CONTROLLERS["ours.pd_dob"], fit, GAINS)
    assert law.params.hat == short.friction and law.params.kp == GAINS["kp"]
    for name, value in short.friction._asdict().items():
        assert value == float(f"{value:.3g}")
        assert abs(value / getattr(fit.friction, name) - 1.0) < 5e-3
