"""Units of logs, as people write them, and what they are in SI.

A unit may have a factor before it: ``5e-8 m`` is the unit of counts of 50 nm, ``10 mm`` that of turns of a screw with
10 mm of lead.
"""

from __future__ import annotations

import math
import re

from leadscrew.util.errors import ValueRefused

LENGTHS = {
    "m": ("m", 1.0), "cm": ("m", 1e-2), "mm": ("m", 1e-3), "um": ("m", 1e-6), "nm": ("m", 1e-9), "in": ("m", 0.0254),
    "rad": ("rad", 1.0), "mrad": ("rad", 1e-3), "deg": ("rad", math.pi / 180.0), "rev": ("rad", 2.0 * math.pi),
}  # fmt: skip
"""Kind and size in SI by unit of position."""

TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0}
"""Seconds by unit of time."""

DRIVES = {
    "N": ("N", 1.0), "kN": ("N", 1e3), "mN": ("N", 1e-3), "uN": ("N", 1e-6), "N m": ("N m", 1.0), "N mm": ("N m", 1e-3),
    "mN m": ("N m", 1e-3), "kN m": ("N m", 1e3), "V": ("V", 1.0), "mV": ("V", 1e-3), "A": ("A", 1.0),
    "mA": ("A", 1e-3), "%": ("1", 1e-2), "1": ("1", 1.0),
}  # fmt: skip
"""The unit that is kept, and the size in it, by unit of the drive."""

_OTHER = {
    "micron": "um", "microns": "um", "inch": "in", "inches": "in", "metre": "m", "meter": "m", "degree": "deg",
    "degrees": "deg", "\u00b0": "deg", "radian": "rad", "radians": "rad", "turn": "rev", "turns": "rev",
    "sec": "s", "second": "s", "seconds": "s", "msec": "ms", "usec": "us", "nsec": "ns", "millimetre": "mm",
    "millimeter": "mm", "nm": "nm", "Nm": "N m", "N*m": "N m", "N.m": "N m", "N\u00b7m": "N m", "N-m": "N m",
    "newton": "N", "newtons": "N", "volt": "V", "volts": "V", "amp": "A", "ampere": "A", "amps": "A", "-": "1",
    "percent": "%", "Nmm": "N mm", "mNm": "mN m", "kNm": "kN m", "cnt": "counts", "count": "counts", "cts": "counts",
    "inc": "counts", "sample": "samples", "cycles": "samples", "rpm": "rev/min", "1/min": "rev/min",
    "m/sec": "m/s", "mm/sec": "mm/s", "ipm": "in/min",
}  # fmt: skip

_FACTOR = re.compile(r"^([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*\*?\s*(\S.*)$")


def plain(unit: str) -> str:
    """The unit as the tables here write it: ``Nm`` is ``N m``, the micro sign is ``u``."""
    text = " ".join(unit.replace("\u00b5", "u").replace("\u03bc", "u").split())
    return _OTHER.get(text, _OTHER.get(text.casefold(), text)) if text not in DRIVES else text


def known(unit: str) -> bool:
    """Whether it is the unit of something that a log of an axis holds, counts and samples included."""
    text = plain(unit)
    if text in ("counts", "samples"):
        return True
    over, slash, under = text.partition("/")
    if slash:
        under = under.replace("^2", "").replace("\u00b2", "").replace("2", "")
        return over in LENGTHS and under in TIMES
    return text in LENGTHS or text in TIMES or text in DRIVES


def length_in(unit: str) -> tuple[str, float]:
    """Kind (m or rad) of a unit of position, and its size in it.

    Raises:
        ValueRefused: not known, or counts without their size.
    """
    factor, text = _factored(unit)
    if text == "counts":
        raise ValueRefused(
            "position in counts: give the size of one count as its unit, for example --unit position='5e-8 m'"
        )
    if text not in LENGTHS:
        raise ValueRefused(f"{unit!r} is no unit of position; known are {', '.join(LENGTHS)}, and '5e-8 m' for counts")
    kind, size = LENGTHS[text]
    return kind, factor * size


def speed_in(unit: str) -> tuple[str, float]:
    """Kind (m or rad) of a unit of velocity, and its size in that a second.

    Raises:
        ValueRefused: not known.
    """
    factor, text = _factored(unit)
    over, _, under = text.partition("/")
    if over not in LENGTHS or under not in TIMES:
        raise ValueRefused(f"{unit!r} is no unit of velocity; expected one such as m/s, mm/s, mm/min, rad/s or rpm")
    kind, size = LENGTHS[over]
    return kind, factor * size / TIMES[under]


def time_in(unit: str) -> float:
    """Seconds in a unit of time.

    Raises:
        ValueRefused: not known, or samples without their period.
    """
    factor, text = _factored(unit)
    if text == "samples":
        raise ValueRefused("time in samples: give the period as its unit, for example --unit time='0.001 s'")
    if text not in TIMES:
        raise ValueRefused(f"{unit!r} is no unit of time; known are {', '.join(TIMES)}, and '0.001 s' for samples")
    return factor * TIMES[text]


def drive_in(unit: str) -> tuple[str, float]:
    """The unit that is kept for a unit of the drive, and its size in it.

    Raises:
        ValueRefused: not known.
    """
    factor, text = _factored(unit)
    if text not in DRIVES:
        raise ValueRefused(f"{unit!r} is no unit of the drive; known are {', '.join(DRIVES)}")
    kept, size = DRIVES[text]
    return kept, factor * size


def _factored(unit: str) -> tuple[float, str]:
    whole = plain(unit)
    found = _FACTOR.match(whole)
    if whole in DRIVES or found is None or whole in _OTHER:
        return 1.0, whole
    factor = float(found[1])
    if factor == 0.0 or not math.isfinite(factor):
        raise ValueRefused(f"{unit!r}: the factor of a unit must be a finite number other than 0")
    return factor, plain(found[2])
