"""Draws docs/images from the studies and the examples: run it again when a figure of the README or a guide has changed.

python docs/make_images.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from leadscrew import catalogue, experiment, fuzzy
from leadscrew.report import fuzzy as pictures

IMAGES = {"lathe": ("vud_lathe", "fig11b_position_m170")}
"""Name of the image; study and picture that it is."""
EXAMPLES = Path(__file__).parents[1] / "examples"


def fuzzy_images(folder: Path) -> None:
    """The fuzzy system of the guide: its sets, its surface, its rules along the run of the example."""
    system = fuzzy.read(EXAMPLES / "axis.fll")
    found = experiment.read(EXAMPLES / "axis_on_the_lathe.toml")
    loop = found.loop()
    run = loop.run(found.seconds())
    p = loop.blocks["controller"].params
    error = run["error"]
    points = np.column_stack([p.scale_e * error, p.scale_de * np.diff(error, prepend=error[0])])
    for name, figure in (
        ("sets", pictures.membership_figure(system)),
        ("surface", pictures.surface_figure(system)),
        ("activity", pictures.activity_figure(system, run.time, points)),
    ):
        figure.savefig(folder / f"fuzzy_{name}.png", dpi=110)


def main(folder: Path = Path(__file__).parent / "images") -> None:
    """Draws every image."""
    folder.mkdir(exist_ok=True)
    for image, (study, wanted) in IMAGES.items():
        result = catalogue.study(study).evaluate(lambda what, done: None)
        picture = next(p for p in result.pictures if p.name == wanted)
        picture.draw().savefig(folder / f"{image}.png", dpi=110)
    fuzzy_images(folder)


if __name__ == "__main__":
    main()
