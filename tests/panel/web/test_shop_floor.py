"""What can be read and pressed at a machine: contrast, sizes of text, of buttons, motion; from the style sheets."""

import re
from pathlib import Path

import pytest

from tests.panel.web.test_views import WEB

SHEETS = ("style.css", "side.css")
LEAST_CONTRAST = 4.5
"""Of text, WCAG 2.1 level AA."""
LEAST_TEXT_PX = 12.0
LEAST_TOUCH_PX = 40.0
ROOT_PX = 14.0


def text(sheet: str) -> str:
    return re.sub(r"/\*.*?\*/", "", (WEB / sheet).read_text(encoding="utf-8"), flags=re.S)


def rules() -> list[tuple[str, dict[str, str]]]:
    """Selector and declarations of every rule, those inside media queries too."""
    found = []
    for sheet in SHEETS:
        for selector, body in re.findall(r"([^{}]+)\{([^{}]*)\}", text(sheet)):
            pairs = (part.split(":", 1) for part in body.split(";") if ":" in part)
            found.append((selector.strip(), {k.strip(): v.strip() for k, v in pairs}))
    return found


NAMED = {k: v for _, body in rules() for k, v in body.items() if k.startswith("--")}


def colour(value: str) -> str | None:
    """``#rrggbb`` of a declared colour, None where it is none or a transparent one."""
    for name, known in NAMED.items():
        value = value.replace(f"var({name})", known)
    found = re.search(r"#([0-9a-f]{6}|[0-9a-f]{3})\b", value.lower())
    if not found:
        return None
    digits = found[1]
    return "#" + ("".join(2 * d for d in digits) if len(digits) == 3 else digits)


def luminance(value: str) -> float:
    parts = [int(value[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [p / 12.92 if p <= 0.03928 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one: str, other: str) -> float:
    light, dark = sorted((luminance(one), luminance(other)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


def test_the_contrast_is_computed_as_wcag_does_it() -> None:
    assert contrast("#000000", "#ffffff") == pytest.approx(21.0)
    assert contrast("#777777", "#ffffff") == pytest.approx(4.48, abs=0.005)


GROUNDS = ("--sheet", "--ground")
DARK = (".notice", ".scope-flag")
"""Rules whose text stands on the dark ground that another rule gives them."""


def test_every_colour_of_text_is_told_from_its_ground_by_4_5_to_1() -> None:
    checked = 0
    for selector, body in rules():
        ink, own = colour(body.get("color", "")), colour(body.get("background", ""))
        if ink is None or any(selector.startswith(name) for name in DARK):
            continue
        for ground in [own] if own else [colour(NAMED[name]) or "" for name in GROUNDS]:
            assert contrast(ink, ground) >= LEAST_CONTRAST, f"{selector}: {ink} on {ground}"
            checked += 1
    assert checked > 30


def test_text_on_coloured_grounds_is_told_from_them_by_4_5_to_1() -> None:
    inks = [colour(NAMED["--ink"]), colour(NAMED["--soft"])]
    for selector, body in rules():
        ground = colour(body.get("background", ""))
        if ground is None or "color" in body or "::" in selector or luminance(ground) < 0.3:
            continue
        for ink in inks:
            assert ink is not None and contrast(ink, ground) >= LEAST_CONTRAST, f"{selector}: {ink} on {ground}"
    assert contrast("#ffffff", "#17222c") >= LEAST_CONTRAST, "notices"


def test_no_text_of_the_page_is_smaller_than_12_px() -> None:
    sizes = []
    for sheet in SHEETS:
        for size, unit in re.findall(r"font(?:-size)?:[^;{}]*?\b([0-9]*\.?[0-9]+)(rem|px)", text(sheet)):
            sizes.append(float(size) * (ROOT_PX if unit == "rem" else 1.0))
    assert len(sizes) > 30 and min(sizes) >= LEAST_TEXT_PX
    for script in sorted(WEB.glob("*.js")):
        words = script.read_text(encoding="utf-8")
        drawn = re.findall(r"\bsize: ([0-9]+), colour|\b([0-9]+)px (?:system-ui|\$)|\$\{([0-9]+) \* dense\}px", words)
        for size in (int(next(filter(None, found))) for found in drawn):
            assert size >= LEAST_TEXT_PX, f"{script.name}: {size} px"


def test_what_is_pressed_while_the_machine_runs_is_at_least_40_px_high() -> None:
    assert float(NAMED["--touch"].removesuffix("px")) >= LEAST_TOUCH_PX
    selectors = next(s for s, body in rules() if body.get("min-height") == "var(--touch)").split(",")
    named = {s.strip() for s in selectors}
    assert {"#run-buttons button", "#control", "#speed", "#tabs button", "#undo", "#redo", ".card button"} <= named
    for selector, body in rules():
        small = body.get("min-height", "")
        if selector in named and "touch" not in small:
            assert not small, f"{selector} takes its height back: {small}"


def test_the_page_moves_nothing_where_less_motion_is_asked_for() -> None:
    assert "prefers-reduced-motion: reduce" in text("style.css")
    for sheet in SHEETS:
        assert not re.search(r"(?:animation|transition):(?! none)", text(sheet)), (
            "nothing is animated in the first place"
        )


def test_every_module_of_the_page_is_short_and_used() -> None:
    names = {p.name for p in WEB.glob("*.js")}
    said = "".join(p.read_text(encoding="utf-8") for p in [*WEB.glob("*.js"), WEB / "index.html"])
    for name in names:
        assert len((WEB / name).read_text(encoding="utf-8").splitlines()) <= 250, name
        assert re.search(rf"[/\"]{re.escape(name)}\"", said), f"{name} is imported nowhere"
    assert isinstance(WEB, Path)
