"""What is in a running HAL, as ``halcmd show`` lists it: pins, signals, parameters, functions, threads, components."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from leadscrew.util.errors import LeadscrewError

OURS = "leadscrew."
"""What signals that we make begin with."""
HELPER = "leadscrew-panel."
"""What the helper's component begins with; its process number follows."""
LOADED = f"{OURS}loaded"
"""A signal that says that sampler was loaded by us."""
USED = f"{OURS}channel."
"""A signal that says which channel of a sampler of somebody else is ours; its number follows."""
TYPES = {"float": "f", "bit": "b", "s32": "s", "u32": "u"}
"""Types that sampler takes, and their letters."""
NO_HAL = "no HAL runs here: start LinuxCNC (or halrun) first, and the panel as the same user"


class HalRefused(LeadscrewError):
    """HAL, or what is in it, does not allow what was asked; one sentence says why."""


@dataclass(frozen=True)
class Pin:
    """A pin or a parameter."""

    name: str
    owner: str
    type: str
    direction: str
    """``IN``, ``OUT``, ``I/O`` of a pin; ``RW``, ``RO`` of a parameter."""
    signal: str = ""
    """That a pin is linked to."""
    old_name: str = ""
    """Its own name, where it goes by an alias."""


@dataclass(frozen=True)
class Component:
    """A loaded component."""

    name: str
    realtime: bool
    pid: int = 0
    """Of the process of a component outside real time."""


@dataclass(frozen=True)
class Thread:
    """A thread and the functions in it, in order."""

    name: str
    period_ns: int
    functions: tuple[str, ...]


@dataclass(frozen=True)
class Hal:
    """All of it, by name."""

    pins: Mapping[str, Pin]
    parameters: Mapping[str, Pin]
    signals: Mapping[str, str]
    """Type by name."""
    components: Mapping[str, Component]
    functions: Mapping[str, int]
    """Users by name: 0 is in no thread."""
    threads: Mapping[str, Thread]

    def helpers(self) -> list[Component]:
        """The helpers of panels that are attached and alive."""
        return [c for c in self.components.values() if c.name.startswith(HELPER) and alive(c.pid)]


def alive(pid: int) -> bool:
    """Whether a process is there and is a helper of ours."""
    try:
        return b"attached.py" in Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:
        return False


def halcmd(*words: str, timeout: float = 20.0) -> str:
    """What a command of HAL prints.

    Raises:
        HalRefused: there is no halcmd, or the command fails; with the first line that it printed.
    """
    try:
        done = subprocess.run(
            ["halcmd", "-s", *words], capture_output=True, text=True, check=False, timeout=timeout,
            stdin=subprocess.DEVNULL, env={**os.environ, "LC_ALL": "C"},
        )  # fmt: skip
    except FileNotFoundError:
        raise HalRefused("halcmd is not installed: the panel attaches to LinuxCNC on the same computer") from None
    except subprocess.TimeoutExpired:
        raise HalRefused(f"halcmd {' '.join(words)} did not answer within {timeout:g} s") from None
    if done.returncode:
        told = [x for x in done.stderr.splitlines() if x.strip() and not x.startswith(("Note:", "Running with"))]
        raise HalRefused(f"halcmd {' '.join(words)}: {told[0] if told else f'ended with {done.returncode}'}")
    return done.stdout


def running() -> Hal:
    """What is in the HAL that runs here.

    Raises:
        HalRefused: none runs, or halcmd is not installed.
    """
    if shutil.which("halcmd") is None:
        raise HalRefused("halcmd is not installed: the panel attaches to LinuxCNC on the same computer")
    kinds = ("pin", "param", "sig", "comp", "funct", "thread", "alias")
    hal = listed({kind: halcmd("show", kind) for kind in kinds})
    if not hal.threads:
        raise HalRefused(NO_HAL)
    return hal


def listed(text: Mapping[str, str]) -> Hal:
    """What ``halcmd -s show`` has printed, by kind.

    Values hold no blanks, and names cannot.
    """
    rows = {kind: [w for w in map(str.split, printed.splitlines()) if w] for kind, printed in text.items()}
    old = {w[0]: w[1] for w in rows["alias"] if len(w) == 2}
    pins = (Pin(w[4], w[0], w[1], w[2], w[6] if len(w) > 6 else "", old.get(w[4], "")) for w in rows["pin"])
    parameters = (Pin(w[4], w[0], w[1], w[2], "", old.get(w[4], "")) for w in rows["param"])
    components = (
        Component(w[2], w[1] == "RT", int(w[3]) if w[1] != "RT" and len(w) > 3 and w[3].isdigit() else 0)
        for w in rows["comp"]
    )
    threads = (Thread(w[2], int(w[0]), tuple(w[5:])) for w in rows["thread"])
    return Hal(
        pins={p.name: p for p in pins}, parameters={p.name: p for p in parameters},
        signals={w[2]: w[0] for w in rows["sig"]}, components={c.name: c for c in components},
        functions={w[5]: int(w[4]) for w in rows["funct"]}, threads={t.name: t for t in threads},
    )  # fmt: skip
