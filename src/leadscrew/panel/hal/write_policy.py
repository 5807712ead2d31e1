"""What the panel never writes: everything that enables, stops, moves or guards a machine, by rule.

The rules do not depend on how a pin is called alone. A name is looked at last.

1. Bits are not written. HAL enables, stops, homes, brakes and resets by bits.
2. Only an input pin that no signal drives, or a parameter that HAL says may be written.
3. Only components of the real-time part: what runs outside it is user interfaces, input and output, drives by Modbus.
4. Not the components that move and guard: motion, homing, E-stop latch, watchdog, charge pump, a PLC.
5. No name, nor the name that an alias hides, with a word that enables, stops or guards.
"""

from __future__ import annotations

import re

from leadscrew.panel.hal.show import Hal, Pin

GUARDS = frozenset({
    "motmod", "motion", "tpmod", "homemod", "tp", "estop_latch", "watchdog", "charge_pump", "classicladder_rt",
    "supply", "sim_home_switch", "sampler", "streamer", "plasmac", "moveoff", "eoffset_per_angle", "gantry", "orient",
    "threads",
})  # fmt: skip
"""Components of LinuxCNC that move or guard a machine, or that belong to this panel."""
WORDS = frozenset({
    "en", "ena", "on", "off", "amp", "emc", "emcmot", "run", "sto", "ss1", "ss2", "power", "home", "stop", "fault",
    "safe", "safety", "door", "guard", "tmax", "time", "jog", "motion", "joint", "axis", "machine", "index",
    "lock", "kill",
})  # fmt: skip
"""Refused as a whole word of a name."""
PARTS = ("enabl", "disabl", "estop", "e-stop", "e_stop", "emergency", "brake", "homing", "unhome", "homed", "iocontrol",
         "halui", "watchdog", "interlock", "inhibit", "deadman", "abort", "restart", "halt", "charge-pump",
         "chargepump", "timeout", "machine-on", "machine-is-on", "spindle-on", "spindle.0.on", "motion-")  # fmt: skip
"""Refused anywhere in a name."""


def refused(name: str, type_: str, hal: Hal) -> str:
    """Why a pin or parameter is not written, as the end of a sentence that begins with its name; empty: it may be.

    ``type_`` is ``float`` or ``int``, as the file says.
    """
    item = hal.pins.get(name) or hal.parameters.get(name)
    if item is None:
        return "is not in this HAL"
    return _by_kind(item, type_) or _by_owner(item, hal) or next(
        (found for found in map(by_name, (item.name, item.old_name)) if found), ""
    )  # fmt: skip


def _by_kind(item: Pin, type_: str) -> str:
    if item.type == "bit":
        return "is a bit: the panel writes no bits, because HAL enables and stops by bits"
    if item.type not in ("float", "s32", "u32"):
        return f"is of type {item.type}: the panel writes float, s32 and u32 only"
    if (item.type == "float") != (type_ == "float"):
        return f"is of type {item.type} in HAL, and the file says type = '{type_}'"
    if item.direction == "RO":
        return "is a parameter that may only be read"
    if item.direction in ("OUT", "I/O"):
        return f"is written by its component {item.owner} ({item.direction}): the panel writes inputs only"
    if item.signal:
        return f"is driven by the signal {item.signal}: the panel writes only pins that nothing else drives"
    return ""


def _by_owner(item: Pin, hal: Hal) -> str:
    owner = hal.components.get(item.owner)
    if item.owner.startswith("__") or item.owner in GUARDS:
        return f"belongs to {item.owner}, which moves, times or guards the machine"
    if owner is None or not owner.realtime:
        return f"belongs to {item.owner}, which runs outside real time: the panel writes to real-time components only"
    return ""


def by_name(name: str) -> str:
    """Why a name is refused, whatever it belongs to; empty: it may be."""
    plain = name.lower()
    words = {w for w in re.split(r"[^a-z0-9]+", plain) if w}
    words |= {w.rstrip("0123456789") for w in words if w.rstrip("0123456789") and w not in ("ss1", "ss2")}
    part = next((x for x in PARTS if x in plain), "") or next((x for x in sorted(words) if x in WORDS), "")
    return f"has {part!r} in its name, which says that it enables, stops, times or guards the machine" if part else ""
