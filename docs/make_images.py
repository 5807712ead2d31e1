"""Draws docs/images from the studies: run it again when a figure of the README has changed.

python docs/make_images.py
"""

from __future__ import annotations

from pathlib import Path

from leadscrew import catalogue

IMAGES = {"lathe": ("vud_lathe", "fig11b_position_m170")}
"""Name of the image; study and picture that it is."""


def main(folder: Path = Path(__file__).parent / "images") -> None:
    """Draws every image."""
    folder.mkdir(exist_ok=True)
    for image, (study, wanted) in IMAGES.items():
        result = catalogue.study(study).evaluate(lambda what, done: None)
        picture = next(p for p in result.pictures if p.name == wanted)
        picture.draw().savefig(folder / f"{image}.png", dpi=110)


if __name__ == "__main__":
    main()
