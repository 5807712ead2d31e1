"""The stage under a PD with observer and a table of feed-forward."""

import numpy as np

from leadscrew.controllers._feed_forward_table import feed_forward_table
from leadscrew.controllers._pd_dob import pd_dob
from tests.controllers.stage_loop import stage_loop


def taught():
    table = 0.3 * np.sin(np.arange(64) * 0.7)
    return stage_loop(feed_forward_table(pd_dob(max_torque=40.0), table, 0.0213), encoder_mm=1e-5)
