"""The names that a controller has in LinuxCNC's HAL: its component, its pins, its parameters."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence

from leadscrew.kernel.errors import ValueRefused

LONGEST = 47
"""HAL_NAME_LEN of LinuxCNC 2.9."""

BY_ROLE = ("command", "feedback", "output", "command-deriv", "command-accel")
FIXED = (
    *BY_ROLE,
    "error",
    "enable",
    "index-enable",
    "saturated",
    "fault",
    "fault-code",
    "bad-parameter",
    "maxoutput",
    "max-following-error",
    "max-wrong-way",
    "period-design",
    "every",
    "rediscretise",
    "inside",
    "time",
    "tmax",
    "tmax-increased",
)
"""Names that the component or HAL itself uses, whether this controller has them or not."""


def component(name: str) -> str:
    """The component's name in HAL: ``demo_pd`` is ``demo-pd``, its first instance ``demo-pd.0``."""
    return name.removeprefix("hal_").replace("_", "-").rstrip("-")


def _free(name: str, prefix: str, taken: set[str]) -> str:
    """The name with dashes for underscores, behind the prefix where it is taken."""
    free = re.sub("_+", "-", name).strip("-")
    while free in taken:
        free = f"{prefix}-{free}"
    taken.add(free)
    return free


def pins(ports: Iterable[tuple[str, str]]) -> list[str]:
    """Names of the pins of inputs or outputs, given each one's C identifier and role."""
    taken = set(FIXED)
    used: set[str] = set()

    def named() -> Iterator[str]:
        for name, role in ports:
            if role in BY_ROLE and role not in used:
                used.add(role)
                yield role
            else:
                yield _free(name, "pin", taken)

    return list(named())


def parameters(knobs: Iterable[str], others: Iterable[str]) -> list[str]:
    """Names of the parameters of knobs, given their C identifiers and the pins' names."""
    taken = {*FIXED, *others}
    return [_free(k, "knob", taken) for k in knobs]


def fit(name: str, within: Sequence[str]) -> None:
    """Refuses a component whose pins would not fit into a HAL name.

    Raises:
        ValueRefused: a name is too long.
    """
    longest = max(within, key=len)
    full = f"{component(name)}.0.{longest}"
    if len(full) > LONGEST:
        raise ValueRefused(
            f"{full} has {len(full)} characters, and LinuxCNC allows names of {LONGEST}: "
            f"export under a name that is {len(full) - LONGEST} characters shorter than {name}"
        )
