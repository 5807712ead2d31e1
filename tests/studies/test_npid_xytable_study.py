"""The study of the XY table as a user meets it: its loops, its scenarios, its verdicts, its refusals."""

import numpy as np
import pytest

from leadscrew.analysis.stability.loop import sampled_loop
from leadscrew.controllers._wrapping import takes_motion
from leadscrew.resolve import study
from leadscrew.studies import results
from leadscrew.util.errors import LeadscrewError
from tests.budget import WHOLE

TABLE = study("npid_xytable")


@pytest.mark.slow
def test_every_controller_fits_into_scenarios_of_all_kinds_and_gets_the_command_that_it_takes():
    for i, (name, block) in enumerate(TABLE.controllers.items()):
        for j, scenario in enumerate(TABLE.scenarios):
            if WHOLE or (i + j) % 5 == 0:
                signals = TABLE.loop(name, scenario).signals
                assert signals["output"] is not None, (name, scenario)
                assert takes_motion(block) == hasattr(signals["command"], "velocity"), (name, scenario)


def test_a_scenario_on_a_machine_has_its_drive():
    """At 15 mV a drive that loses 20 mV stands still."""
    dead, sound = (TABLE.loop("paper.pid", s).blocks["actuator"] for s in ("sine_1mm_on_dead_zone", "sine_1mm"))
    assert dead.step(dead.params, 0.015) == 0.0 and dead.step(dead.params, 0.05) == pytest.approx(0.03)
    assert sound.step(sound.params, 0.015) == 0.015


def test_the_verdicts_of_the_key_claims_are_those_that_follow_from_their_numbers():
    verdicts = {c.id.removeprefix("npid_xytable."): c.verdict for c in results.evaluate(TABLE, key=True).claims}
    assert verdicts["gain_at_e_max"] == "reproduced" and verdicts["intercept"] == "not reproduced"
    assert verdicts["popov_from_one"] == "fitted" and verdicts["adjusts_its_gain"] == "reproduced with a change"
    assert verdicts["mean_reduction"] == "not reproduced", "52 % is above 8 to 40 %"


def test_values_out_of_range_are_refused_with_their_range():
    with pytest.raises(LeadscrewError, match=r"amplitude_mm = -1.*\[0, 500\]"):
        TABLE.scenario("spindle_1000", {"amplitude_mm": -1.0})
    with pytest.raises(LeadscrewError, match=r"column = 1500.*Table II has \[1000, 2000, 3000\]"):
        TABLE.loop("paper.pid", "spindle_1000", {"scenario.column": 1500})


def test_a_constant_gain_starts_to_oscillate_in_time_where_nyquist_says():
    loop = TABLE.loop("paper.pid", "step_10um")
    limit, gains = sampled_loop(loop).gain_limit(), TABLE.controllers["paper.pid"].params
    factors = limit * np.array([0.995, 1.005])
    varied = {f"controller.{key}": factors * getattr(gains, key) for key in ("kp", "ki", "kd")}
    e = loop.batch(1.5, varied, record="true_error")["true_error"]
    early, late = e[:, 500:1000].std(axis=1), e[:, -500:].std(axis=1)
    assert late[0] < 0.9 * early[0] and late[1] > 1.1 * early[1]
