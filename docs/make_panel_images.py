"""Draws the pictures of the operator panel in docs/images: starts a panel, works with it in Chromium, takes pictures.

python docs/make_panel_images.py [panel_live panel_scope panel_why panel_circle]
"""

from __future__ import annotations

import io
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from PIL import Image

sys.path.insert(0, str(Path(__file__).parents[1]))  # tests.panel: a panel in a process of its own, and a page on it

from tests.panel.browser.chrome import Browsers, View
from tests.panel.served import Served

FOLDER = Path(__file__).parent / "images"
MOST_BYTES = 250_000
COLOURS = 128


def ask(view: View, do: str, **args: Any) -> None:
    """A request as a button sends it."""
    view.js("([what, args]) => panel.send(what, args)", [do, args])


def live(view: View) -> None:
    """Turning at constant force: a weaker controller against the one before it, after a step of the depth of cut."""
    view.choose("grey_turning")
    view.start()
    view.simulate(3.0)
    view.parameter("controller.output_scale", 0.0015)
    view.simulate(1.5)
    ask(view, "disturb", name="depth_step", fields={"step": -0.2, "for_s": 0})
    view.simulate(2.2)
    view.js("() => document.activeElement.blur()")


def scope(view: View) -> None:
    """A ballscrew's reversal captured twice, with another lambda between, the first dashed below the second."""
    view.choose("fsmc_ballscrew")
    view.start()
    view.simulate(0.6)
    view.show("scope")
    page = view.page
    page.get_by_label("Signal", exact=True).select_option("command.position")
    page.get_by_label("Level", exact=True).fill("0.9")
    page.get_by_label("Length", exact=True).fill("0.5")
    for run, lam in enumerate((400.0, 150.0)):
        ask(view, "set", changes={"controller.lam": lam}) if run else None
        view.simulate(0.3)
        page.get_by_role("button", name="Arm", exact=True).click()
        view.until(f"panel.captures.size === {run + 1}", 20)
        page.wait_for_timeout(300)
        if not run:
            page.get_by_role("button", name="Keep as overlay").click()
    page.get_by_role("button", name="Bring both cursors into the picture").click()
    page.wait_for_timeout(300)


def why(view: View) -> None:
    """The lathe's slide in the middle of a move: the rules that fire, the sets in their contracted universe."""
    view.choose("vud_lathe")
    view.page.select_option("#speed", "0.1")
    view.show("why")
    view.start()
    view.simulate(0.25)


def circle(view: View) -> None:
    """Two axes on a circle, after a turn and a half."""
    view.choose("fsmc_ballscrew")
    ask(view, "machine", study="fsmc_ballscrew", controller="ours.fsmc_4khz", scenario="sine_fast", circle=True)
    view.until("panel.machine.circle && panel.state.running === 'stopped'")
    view.page.wait_for_timeout(300)
    view.show("why")
    for name in ("Phase plane", "Rules", "Sets"):
        button = view.page.get_by_role("group", name="Pictures shown").get_by_role("button", name=name)
        if button.count():
            button.click()
    view.start()
    view.simulate(2.6)


IMAGES: dict[str, Callable[[View], None]] = {
    "panel_live": live, "panel_scope": scope, "panel_why": why, "panel_circle": circle,
}  # fmt: skip
"""By the name of the file."""


def take(view: View, path: Path) -> None:
    """A picture of the page with few colours, so that it is small."""
    view.page.mouse.move(1, 1)
    view.page.wait_for_timeout(200)
    shot = Image.open(io.BytesIO(view.page.screenshot())).convert("RGB")
    shot.quantize(COLOURS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE).save(path, optimize=True)
    if path.stat().st_size > MOST_BYTES:
        raise SystemExit(f"{path.name} has {path.stat().st_size} bytes; up to {MOST_BYTES} are taken")


def main(names: list[str]) -> None:
    """All pictures, or those named."""
    with tempfile.TemporaryDirectory() as home:
        panel, browsers = Served(Path(home)), Browsers()
        try:
            for name in names or list(IMAGES):
                began = time.monotonic()
                with browsers.view(panel) as view:
                    view.in_control()
                    ask(view, "speed", value=1)
                    IMAGES[name](view)
                    take(view, FOLDER / f"{name}.png")
                print(f"{name}.png: {(FOLDER / f'{name}.png').stat().st_size} bytes, {time.monotonic() - began:.1f} s")
        finally:
            browsers.close()
            panel.end()


if __name__ == "__main__":
    main(sys.argv[1:])
