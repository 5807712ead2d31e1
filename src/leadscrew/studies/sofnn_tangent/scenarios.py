"""What is cut: three lines in three materials, quietly, with a change of material on the way, lap after lap, straight.

The paper shows one curve (Figure 5) and says nothing of the material. All of this is a reconstruction.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.kernel.sheet import Doc, Ge, Gt, Le, Unit
from leadscrew.plants.flexible_cut import MATERIALS, Material
from leadscrew.studies.sofnn_tangent.lines import FEED, LAPS, MATERIAL_NAMES, PERIOD_S, samples_of
from leadscrew.studies.study import Scenario


class Cut(NamedTuple):
    """A line in a material."""

    material: Material = Material()
    changed: Material = MATERIALS["foam"]
    change_share: Annotated[float, Ge(0), Le(1), Doc("share of the way after which it changes; 0: never")] = 0.0
    feed: Annotated[float, Unit("mm/s"), Gt(0), Doc("speed of the blade along the line")] = FEED
    texture_deg: Annotated[float, Unit("deg"), Ge(0), Doc("standard deviation of the texture")] = 0.25
    texture_mm: Annotated[float, Unit("mm"), Gt(0), Doc("its correlation length")] = 3.0
    noise_deg: Annotated[float, Unit("deg"), Ge(0), Doc("standard deviation of a reading of the camera")] = 0.15
    trailing_s: Annotated[float, Unit("s"), Ge(0), Doc("time from the blade to where the camera sees")] = 0.04
    zero_deg: Annotated[float, Unit("deg"), Doc("error of the camera's zero")] = 0.0
    step_deg: Annotated[float, Unit("deg"), Doc("change of the steady shear")] = 0.0
    step_at_s: Annotated[float, Unit("s"), Ge(0), Doc("when it comes")] = 1.0


def _cut(name: str, doc: str, **values: float | Material) -> Scenario:
    """A scenario on the line that its name begins with, to the end of the line."""
    asked = Cut()._replace(**values)  # type: ignore[arg-type]
    return Scenario(name, asked, doc, (samples_of(name, asked.feed) + 1) * PERIOD_S)


LONG = 20
"""Laps of the long run on a closed line."""

STEP_S = 6.0

SCENARIOS: dict[str, Scenario] = {
    s.name: s
    for s in (
        *(
            _cut(f"{line}_{material}", f"the {line} in {material}", material=MATERIALS[material])
            for line in LAPS
            for material in MATERIAL_NAMES
        ),
        _cut("wave_fabric_quiet", "the wave in fabric, without texture and noise", texture_deg=0.0, noise_deg=0.0),
        *(_cut(f"{line}_change", f"the {line}: fabric, from half on foam", change_share=0.5) for line in LAPS),
        *(_cut(f"{line}_fabric_on_mismatch", f"the {line} in fabric that is not as the model says") for line in LAPS),
        Scenario("flower_laps", Cut(), f"{LONG} laps of the flower in fabric", LONG * 7.9),
        Scenario("straight", Cut(), "straight on, in fabric, 10,000 samples", 100.0),
        Scenario(
            "step",
            Cut(material=Material(fibre=0.0, bias=0.0), step_deg=-5.0, texture_deg=0.0, noise_deg=0.0),
            "straight on, and after 1 s the shear changes by -5 degrees",
            STEP_S,
        ),
    )
}
"""By name."""
