"""How columns of force tables are called, and in which units they may stand."""

from __future__ import annotations

import re
from typing import NamedTuple

NAMES = {
    "feed": ("feed", "feed_per_rev", "feed_per_revolution", "fn", "f_n", "fr", "f_r"),
    "depth": ("depth", "depth_of_cut", "ap", "a_p", "doc"),
    "force": ("force", "main_force", "cutting_force", "main_cutting_force", "tangential_force", "fc", "f_c"),
    "feed_force": ("feed_force", "axial_force", "ff", "f_f"),
    "passive_force": ("passive_force", "radial_force", "thrust_force", "fp", "f_p"),
    "speed": ("cutting_speed", "speed", "vc", "v_c"),
    "spindle": ("spindle", "spindle_speed", "rpm", "spindle_rpm"),
}
"""What a column may be called, in lower case and with underscores; ``f``, ``F`` and ``n`` go by their case."""
BY_CASE = {"f": "feed", "F": "force", "n": "spindle"}
NEEDED = ("feed", "depth", "force")
FORCES = ("force", "feed_force", "passive_force")

LENGTHS = {"mm": 1.0, "um": 1e-3, "µm": 1e-3, "μm": 1e-3, "cm": 10.0, "m": 1000.0, "in": 25.4, "inch": 25.4}
TURN = ("/rev", "/r", "_per_rev", "_rev", "/u", "/tr", "")
FORCE_UNITS = {"N": 1.0, "daN": 10.0, "kN": 1000.0, "kgf": 9.80665, "lbf": 4.4482216152605}
PER_MINUTE = "mm/min"
"""A feed that becomes one per revolution by the spindle speed."""
UNITS: dict[str, dict[str, float]] = {
    "feed": {f"{unit}{turn}": by for unit, by in LENGTHS.items() for turn in TURN}
    | dict.fromkeys((PER_MINUTE, "mm_min", "mm_per_min"), 1.0),
    "depth": LENGTHS,
    **dict.fromkeys(FORCES, FORCE_UNITS),
    "speed": {"m/min": 1.0, "m_min": 1.0, "m_per_min": 1.0, "m/s": 60.0, "ft/min": 0.3048, "sfm": 0.3048},
    "spindle": {"1/min": 1.0, "rpm": 1.0, "rev/min": 1.0, "min-1": 1.0, "rev/s": 60.0, "1/s": 60.0},
}
"""Into mm per revolution, mm, N, m/min and 1/min."""
OWN = {
    "feed": "mm/rev", "depth": "mm", "force": "N", "feed_force": "N", "passive_force": "N", "speed": "m/min",
    "spindle": "1/min",
}  # fmt: skip
"""The unit of a column that says none."""


class Word(NamedTuple):
    """What a header says."""

    quantity: str
    unit: str


def understood(header: str) -> Word | None:
    """Quantity and unit of a header such as ``feed (mm/rev)``, ``ap_mm`` or ``Fc [kN]``; ``None`` for another word."""
    name, said = parted(header)
    if name in BY_CASE:
        return _with_unit(BY_CASE[name], said)
    words = re.sub(r"[\s_-]+", "_", name).casefold().split("_")
    for split in range(len(words), 0, -1):
        quantity = _quantity("_".join(words[:split]))
        rest = "_".join(words[split:])
        if quantity is not None and (not rest or (not said and unit_of(quantity, rest) is not None)):
            return _with_unit(quantity, said or rest)
    return None


def parted(header: str) -> tuple[str, str]:
    """Name and unit where the unit stands in brackets at the end."""
    found = re.fullmatch(r"(.*?)\s*[\[(]([^\])]*)[\])]", header.strip())
    return (found[1], found[2].strip()) if found else (header.strip(), "")


def unit_of(quantity: str, text: str) -> str | None:
    """The unit of a quantity as it is written here, whatever the case; ``None`` for a unit that it does not have."""
    asked = text.replace(" ", "").casefold()
    return next((unit for unit in UNITS[quantity] if unit.casefold() == asked), None)


def _quantity(name: str) -> str | None:
    return next((quantity for quantity, names in NAMES.items() if name in names), None)


def _with_unit(quantity: str, text: str) -> Word:
    return Word(quantity, text or OWN[quantity])
