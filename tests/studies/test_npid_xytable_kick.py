"""Chatter of the retuned table under a load: alone, or only after a kick."""

import numpy as np
import pytest

from leadscrew.studies.npid_xytable import chatter


@pytest.mark.slow
def test_chatter_under_12_um_needs_a_kick_and_under_10_um_needs_none():
    loads, kicks = [2.5, 3.0, 10.0, 12.0, 12.0], [0.0, 0.0, 0.0, 0.0, 1e-3]
    measured = chatter.Rows().measure({"disturbance.size": chatter.volts(loads), "disturbance.kick": np.array(kicks)})
    size = measured.peak_to_peak_um
    assert size[0] < chatter.QUIET_UM < size[1]
    assert size[2] > 5.0 and size[3] < 0.01 and size[4] > 5.0
