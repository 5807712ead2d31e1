"""What the page on the variable universe says of the paper's comparison with the original servo, simulated anew."""

import re

import pytest

from leadscrew.catalogue import study
from tests.docs.snippets import ROOT


@pytest.mark.slow
def test_the_page_does_not_say_that_the_original_servo_is_first():
    text = " ".join((ROOT / "docs" / "vud.md").read_text(encoding="utf-8").split())
    lathe = study("vud_lathe")
    within, end = {}, {}
    for name in ("corrected.vud_beta_e", "ours.original_fit"):
        runs = [lathe.loop(name, s).run(4.0) for s in ("fig11a_step_m50", "fig11b_step_m170")]
        position = [abs(r["true_error"]) <= 0.01 * abs(r["command"][0]) for r in runs]
        within[name] = [
            float(r.time[inside.size - inside[::-1].argmin()]) for r, inside in zip(runs, position, strict=True)
        ]
        end[name] = max(1000.0 * abs(r["true_error"][r.time >= 2.0]).max() for r in runs)
    said = re.search(r"after ([\d.]+) and ([\d.]+) s, later than ([\d.]+) and ([\d.]+) s", text)
    assert said, "the sentence on the original servo is gone"
    found = [*within["ours.original_fit"], *within["corrected.vud_beta_e"]]
    assert [float(x) for x in said.groups()] == pytest.approx(found, abs=0.0051)
    assert end["corrected.vud_beta_e"] < 2.0 and end["ours.original_fit"] == pytest.approx(0.3, abs=0.05)
