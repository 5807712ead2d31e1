"""What the page on the XY table says of chatter, simulated anew."""

import numpy as np
import pytest

from tests.docs.snippets import ROOT


@pytest.mark.slow
def test_chatter_under_12_um_needs_a_kick_and_under_10_um_needs_none():
    from leadscrew.studies.npid_xytable import chatter

    page = (ROOT / "docs" / "xy_table.md").read_text(encoding="utf-8")
    (row,) = [line for line in page.splitlines() if line.startswith("| retuning to 2.35")]
    loads = [2.5, 3.0, 10.0, 12.0, 12.0]
    kicks = [0.0, 0.0, 0.0, 0.0, 1e-3]
    found = chatter.Rows().measure({"disturbance.size": chatter.volts(loads), "disturbance.kick": np.array(kicks)})
    size = found.peak_to_peak_um
    assert size[0] < chatter.QUIET_UM < size[1]
    assert f"{size[2]:.1f} um of it at 10 um" in row
    assert f"{size[3]:.4f} um, but {size[4]:.1f} um after a kick of 1 mV" in row
