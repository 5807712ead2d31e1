"""From the file and what is in HAL to what is done at attaching; every fault is found before anything is touched."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from leadscrew.kernel.parameters import nearest
from leadscrew.panel.hal import write_policy
from leadscrew.panel.hal.file import HalFile, Signal
from leadscrew.panel.hal.show import LOADED, OURS, TYPES, USED, Hal, HalRefused, Pin, Thread

MOST_CHANNELS = 8
"""FIFOs that sampler makes."""


@dataclass(frozen=True)
class Source:
    """Where a column comes from."""

    signal: str
    """In HAL; empty: the pin gets a signal of ours."""
    pin: str
    type: str


def plan(file: HalFile, hal: Hal) -> dict[str, Any]:
    """What the helper does: the plan, as JSON can hold it.

    Raises:
        HalRefused: a name that is not in HAL, a pin that cannot be sampled or may not be written, another period, no
            free channel of sampler; names file and key.
    """
    where = file.where
    for parameter in file.parameters:
        known = [*hal.pins, *hal.parameters]
        why = write_policy.refused(parameter.hal, parameter.type, hal)
        if why:
            hint = nearest(parameter.hal, known) if parameter.hal not in known else ""
            raise HalRefused(f"{where}: parameters: {parameter.key}: {parameter.hal} {why}{hint}")
    thread = thread_of(file, hal)
    sources = [source_of(signal, hal, file.where) for signal in file.signals]
    channel, kinds, columns, loaded = _channel(sources, hal, file.where)
    pins = [f"sampler.{channel}.pin.{i}" for i in columns]
    nets: list[list[Any]] = []
    for i, (source, pin) in enumerate(zip(sources, pins, strict=True)):
        nets.append([False, source.signal, pin] if source.signal else [True, f"{OURS}{i}", source.pin, pin])
    depth = max(16, round(file.buffer_s / (thread.period_ns * 1e-9)))
    return {
        "channel": channel, "kinds": kinds, "columns": columns, "loaded": loaded, "thread": thread.name,
        "load": [f"depth={depth}", f"cfg={kinds}"], "made": [LOADED if loaded else f"{USED}{channel}"], "nets": nets,
        "pins": pins, "period_s": thread.period_ns * 1e-9, "on_leave": file.on_leave,
    }  # fmt: skip


def thread_of(file: HalFile, hal: Hal) -> Thread:
    """The thread that is sampled in.

    Raises:
        HalRefused: none of that name, several and none named, or another period.
    """
    where = file.where
    if not file.thread and len(hal.threads) > 1:
        raise HalRefused(f"{where}: thread: HAL has the threads {', '.join(hal.threads)}: name the one to sample in")
    name = file.thread or next(iter(hal.threads))
    if name not in hal.threads:
        raise HalRefused(f"{where}: thread = {name!r} is not in this HAL{nearest(name, list(hal.threads))}")
    thread = hal.threads[name]
    if abs(thread.period_ns * 1e-9 - file.period_s) > 0.01 * file.period_s:
        raise HalRefused(f"{where}: period_s = {file.period_s:g}: the thread {name} has {thread.period_ns * 1e-9:g} s")
    return thread


def source_of(signal: Signal, hal: Hal, where: str) -> Source:
    """Where a signal of the file comes from.

    Raises:
        HalRefused: it is not in HAL, or cannot be sampled.
    """
    name, place = signal.source, f"{where}: signals: source = {signal.source!r}"
    if name in hal.signals:
        return Source(name, "", _type(hal.signals[name], place))
    if name in hal.parameters:
        raise HalRefused(f"{place} is a parameter of HAL: sampler takes pins and signals only")
    if name not in hal.pins:
        raise HalRefused(f"{place} is not in this HAL{nearest(name, [*hal.signals, *hal.pins])}")
    pin: Pin = hal.pins[name]
    if pin.signal:
        return Source(pin.signal, "", _type(pin.type, place))
    if pin.direction != "OUT":
        raise HalRefused(f"{place} is an input that no signal drives: its value changes only when it is written; "
                         "name a signal or an output pin")  # fmt: skip
    return Source("", name, _type(pin.type, place))


def _type(found: str, place: str) -> str:
    if found not in TYPES:
        raise HalRefused(f"{place} is of type {found}: sampler takes {', '.join(TYPES)} only")
    return TYPES[found]


def _channel(sources: list[Source], hal: Hal, where: str) -> tuple[int, str, list[int], bool]:
    """A channel of sampler: its number, the types of all its pins, the pins of our columns, whether we load it.

    Sampler can be loaded once only, with all its channels. Where somebody has, one that nobody uses will do.
    """
    if "sampler" not in hal.components:
        return 0, "".join(s.type for s in sources), list(range(len(sources))), True
    for channel in range(MOST_CHANNELS):
        name = f"sampler.{channel}"
        if name not in hal.functions:
            break
        pins = [hal.pins[f"{name}.pin.{i}"] for i in range(100) if f"{name}.pin.{i}" in hal.pins]
        busy = hal.functions[name] or hal.pins[f"{name}.enable"].signal or any(p.signal for p in pins)
        read = f"halsampler{channel}" in hal.components
        columns = _fitted(sources, [TYPES[p.type] for p in pins])
        if not busy and not read and columns is not None:
            return channel, "".join(TYPES[p.type] for p in pins), columns, False
    kinds = "".join(s.type for s in sources)
    raise HalRefused(
        f"{where}: sampler is loaded already, which it can be only once, and no channel of it is free and fits: give "
        f"it one more where it is loaded, as in loadrt sampler depth=...,4000 cfg=...,{kinds}"
    )


def _fitted(sources: list[Source], kinds: list[str]) -> list[int] | None:
    """A pin for each source, by type; None where they do not suffice."""
    free, found = list(range(len(kinds))), []
    for source in sources:
        pin = next((i for i in free if kinds[i] == source.type), None)
        if pin is None:
            return None
        free.remove(pin)
        found.append(pin)
    return found


def left_over(hal: Hal) -> dict[str, Any] | None:
    """What a helper that was killed has left in HAL, as a plan to take it away; None where there is nothing."""
    marker = next((s for s in hal.signals if s == LOADED or s.startswith(USED)), None)
    if marker is None:
        return None
    channel = 0 if marker == LOADED else int(marker.removeprefix(USED))
    name = f"sampler.{channel}"
    thread = next((t for t in hal.threads.values() if name in t.functions), None)
    numbered = [s for s in hal.signals if s.startswith(OURS) and s.removeprefix(OURS).isdigit()]
    return {
        "channel": channel, "loaded": marker == LOADED, "claimed": name in hal.functions, "enabled": True,
        "thread": thread.name if thread else "", "period_s": thread.period_ns * 1e-9 if thread else 0.0,
        "pins": [p for p in hal.pins if p.startswith(f"{name}.pin.") and hal.pins[p].signal],
        "made": [marker, *numbered],
    }  # fmt: skip
