"""What the lathe is asked to do: hold 150 N at 1,200 1/min while the depth of cut stays, falls or rises."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.kernel.sheet import Doc, Ge, Le, Lt, Unit
from leadscrew.references.cutting_program import DepthProgram
from leadscrew.studies.study import Scenario

Noise = Annotated[float, Unit("N"), Ge(0), Le(1000), Doc("standard deviation of one reading of the load cell")]
Filter = Annotated[float, Ge(0), Lt(1), Doc("coefficient of the digital filter, alpha; 0: the raw force is fed back")]


class Turn(NamedTuple):
    """A cut at constant force."""

    force: Annotated[float, Unit("N"), Ge(0), Le(5000), Doc("main cutting force to hold")] = 150.0
    spindle_rpm: Annotated[float, Unit("1/min"), Ge(1), Le(20000), Doc("spindle speed")] = 1200.0
    depth: DepthProgram = DepthProgram()
    runout: Annotated[float, Unit("mm"), Ge(0), Le(1), Doc("amplitude of the depth's change over a revolution")] = 0.01
    noise_n: Noise = 2.0
    keep: Filter = 0.8
    hard_spot: Annotated[float, Ge(0), Le(10), Doc("relative rise of the specific force in a hard spot")] = 0.0
    hard_from_s: Annotated[float, Unit("s"), Ge(0), Doc("when it comes")] = 1.5
    hard_for_s: Annotated[float, Unit("s"), Ge(0), Doc("how long it lasts")] = 0.2


FALLING = DepthProgram(1.0, -0.2, 2.0, 3)
"""1 mm, and 0.2 mm less every 2 s, down to 0.4 mm: below it 150 N need more than 150 mm/min."""

RISING = DepthProgram(0.4, 0.2, 2.0, 3)

SCENARIOS: dict[str, Scenario] = {
    s.name: s
    for s in (
        Scenario("fig6_fixed_depth", Turn(), "150 N at 1 mm and 1,200 1/min, tool in the cut, feed from rest", 3.0),
        Scenario("fig9_falling_depth", Turn(depth=FALLING), "the same; the depth falls by 0.2 mm every 2 s", 8.0),
        Scenario("rising_depth", Turn(depth=RISING), "the depth rises from 0.4 mm by 0.2 mm every 2 s", 8.0),
        Scenario("fixed_depth_on_plant_n", Turn(), "fixed depth with a slower servo that has dead time", 3.0),
        Scenario("fixed_depth_on_plant_f_iron", Turn(), "fixed depth in iron", 3.0),
        Scenario("noise_free", Turn(runout=0.0, noise_n=0.0), "fixed depth without noise and runout", 3.0),
        Scenario("noise_free_falling", Turn(depth=FALLING, runout=0.0, noise_n=0.0), "falling depth without them", 8.0),
        Scenario("raw_force", Turn(keep=0.0), "fixed depth, the force fed back without the digital filter", 3.0),
        Scenario("fig5_feedback", Turn(noise_n=8.0), "fixed depth for 6 s with the scatter of Figure 5", 6.0),
        Scenario("tool_entry", Turn(depth=DepthProgram(entry_s=0.4)), "the edge enters within 0.4 s, then 1 mm", 4.0),
        Scenario("hard_spot", Turn(hard_spot=1.0), "a spot of 0.2 s that doubles the force", 4.0),
    )
}
"""By name."""
