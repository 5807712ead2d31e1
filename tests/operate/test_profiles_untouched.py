"""A machine that nobody touches: bit for bit the study's own loop."""

import pytest

from leadscrew.experiment import Experiment
from leadscrew.operate.profiles import general, profile_of
from tests.operate.playing import STUDIES, roots

CASES = [
    ("vud_lathe", "ours.original_fit", "sequence"),
    ("vud_lathe", "ours.pd", "step_m50_on_limited"),
    ("grey_turning", "ours.inversion", "fig9_falling_depth"),
    ("grey_turning", "corrected.tfc_s9", "hard_spot"),
    ("fsmc_ballscrew", "ours.pd_dob", "step_quintic"),
    ("fsmc_ballscrew", "paper.fsmc", "sine_fast"),
    ("sofnn_tangent", "ours.pid", "step"),
    ("npid_xytable", "ours.pid_ff", "measured_2000"),
    ("npid_xytable", "paper.pid", "sine_1mm_on_friction_medium"),
    ("npid_xytable", "corrected.npid_um", "step_10um"),
]


def same(study, controller, scenario, operated, seconds=2.0):
    """Every signal and state of the plain loop, byte for byte, in the operated one."""
    plain = Experiment(study, controller, scenario).loop()
    ours = operated(plain)
    n = plain.periods(seconds)
    a, b = (x.start().advance(n, record=roots(x.start())) for x in (plain, ours))
    for column, values in a.signals.items():
        assert values.tobytes() == b.signals[column].tobytes(), column
    assert ours.origin == plain.origin
    assert ours.name == plain.name


@pytest.mark.slow
@pytest.mark.parametrize("study", STUDIES)
def test_an_untouched_machine_gives_the_bits_of_its_study(study):
    profile = profile_of(study)
    same(study, profile.controller, profile.scenario, profile.operated, seconds=6.0)


@pytest.mark.slow
@pytest.mark.parametrize(("study", "controller", "scenario"), CASES)
def test_so_does_one_with_another_controller_or_on_another_machine(study, controller, scenario):
    same(study, controller, scenario, profile_of(study).operated)


@pytest.mark.slow
@pytest.mark.parametrize("study", ("vud_lathe", "npid_xytable"))
def test_so_does_the_general_profile(study):
    found = general.profile(study)
    same(study, found.controller, found.scenario, found.operated)


def test_nothing_is_put_where_a_study_has_something():
    for study in ("grey_turning", "sofnn_tangent"):
        profile = profile_of(study)
        loop = Experiment(study, profile.controller, profile.scenario).loop()
        assert profile.operated(loop) is loop
    continuous = Experiment("fsmc_ballscrew", "paper.fsmc", "sine_fast").loop()
    assert profile_of("fsmc_ballscrew").operated(continuous) is continuous
