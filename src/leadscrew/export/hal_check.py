"""Checks an exported HAL component: compiled by halcompile, run by halrun, its golden vectors compared bit for bit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from leadscrew.export import hal, hal_run
from leadscrew.export.core import expected_outputs
from leadscrew.export.verdict import FAILED, GOLDEN, NOT_RUN, Verdict, compared, read_golden
from leadscrew.util.errors import DataError

TARGET = "hal halrun"
LOOP = "hal halrun, loop closed"
MOST_PINS = 20
"""That streamer and sampler take in one FIFO."""
FAULTS = {1: "a number was not finite", 2: "following error", 3: "moved the wrong way", 4: "period of the thread"}


@dataclass(frozen=True)
class Stream:
    """What to stream through a component, call by call."""

    inputs: Mapping[str, np.ndarray]
    """Numbers by pin."""
    bits: Mapping[str, np.ndarray] = field(default_factory=dict)
    """Bits by pin; ``enable`` is on all the time if it is not among them."""
    setup: Sequence[str] = ()
    """HAL commands before the thread starts."""
    thread_ns: int = 0
    """Period of the thread; 0: the controller's own."""
    after: Sequence[str] = ()
    """HAL commands at the end."""


@dataclass(frozen=True)
class Replay:
    """What a component made of a stream."""

    outputs: np.ndarray
    """Rows by call, one column for each output."""
    faults: np.ndarray
    """The fault code of each call."""
    printed: str


def check(folder: Path, manifest: dict[str, Any], speed: int = 300) -> list[Verdict]:
    """Streams every golden row through the component in the real HAL and compares its outputs."""
    why = hal_run.lacking()
    if why:
        return [Verdict(TARGET, NOT_RUN, note=why)]
    inputs, outputs = manifest["inputs"], manifest["outputs"]
    if max(len(inputs), len(outputs) + 1) > MOST_PINS:
        return [Verdict(TARGET, NOT_RUN, note=f"LinuxCNC's streamer takes {MOST_PINS} pins at most")]
    try:
        names, rows = read_golden(folder / GOLDEN)
        wanted = [*(p["name"] for p in inputs), *(p["name"] for p in outputs)]
        if names != wanted:
            raise DataError(f"{folder / GOLDEN}: has the columns {names}, expected {wanted}")
        pins = hal.pins((p["name"], p["role"]) for p in inputs)
        with hal_run.workplace() as place:
            hal_run.install(place, folder, manifest["name"])
            stream = Stream({pin: rows[:, i] for i, pin in enumerate(pins)})
            got = replay(place, manifest, stream, speed)
            found = [
                compared(TARGET, expected_outputs(manifest, rows[:, len(inputs) :]), got.outputs, _note(got, speed))
            ]
            if (folder / f"{manifest['name']}_plant.comp").is_file():
                found.append(closed_loop(place, folder, manifest, rows, speed))
            return found
    except (DataError, hal_run.HalFailed) as error:
        return [Verdict(TARGET, FAILED, note=str(error))]


def closed_loop(place: Path, folder: Path, manifest: dict[str, Any], rows: np.ndarray, speed: int = 300) -> Verdict:
    """Closes the loop in HAL, the exported controller around its simulated machine, and compares every signal.

    In single precision the loop goes its own way after the first rounding, so there is nothing to compare it with.
    """
    if manifest["real"] != "double":
        return Verdict(LOOP, NOT_RUN, note="single precision: the loop that was recorded is in double precision")
    name = manifest["name"]
    hal_run.install(place, folder, f"{name}_plant")
    own, machine = f"{hal.component(name)}.0", f"{hal.component(f'{name}_plant')}.0"
    inputs, outputs = manifest["inputs"], manifest["outputs"]
    ins, outs = (hal.pins((p["name"], p["role"]) for p in side) for side in (inputs, outputs))
    there = [p["name"].replace("_", "-") for p in (*inputs, *outputs)]
    sampled = [f"{machine}.{p}" for p in there[: len(inputs)]] + [f"{own}.{p}" for p in outs]
    thread, count = round(float(manifest["period_s"]) * 1e9), len(rows)
    wires = [
        f"net w{i} {machine}.{a} => {own}.{b} sampler.0.pin.{i}"
        for i, (a, b) in enumerate(zip(there, ins, strict=False))
    ]
    back = [f"net b{i} {own}.{b} => {machine}.{a} sampler.0.pin.{len(inputs) + i}"
            for i, (a, b) in enumerate(zip(there[len(inputs) :], outs, strict=True))]  # fmt: skip
    lines = [
        f"loadrt threads name1=servo period1={thread}",
        f"loadrt sampler depth={count + 10} cfg={'f' * len(sampled)}",
        f"loadrt {name} count=1",
        f"loadrt {name}_plant count=1",
        *(f"addf {f} servo" for f in (f"{machine}.read", own, f"{machine}.write", "sampler.0")),
        *([f"setp {own}.bumpless 0"] if manifest.get("bumpless") else []),
        f"setp {own}.maxoutput 0",
        f"setp {own}.enable 1",
        *wires,
        *back,
        "start",
        *reading(place, count, "f" * len(sampled)),
    ]
    ran(place, lines, thread, count, speed)
    table = taken(place, len(sampled))
    turned = rows.copy()
    turned[:, len(inputs) :] *= manifest["sense"]
    return compared(LOOP, turned, table, f"LinuxCNC {hal_run.version()}: command, feedback and output")


def replay(place: Path, manifest: dict[str, Any], stream: Stream, speed: int = 300) -> Replay:
    """Streams inputs through an installed component and samples its outputs, exactly.

    Raises:
        HalFailed: HAL did not run, or not to the end.
    """
    own = round(float(manifest["period_s"]) * 1e9)
    thread = stream.thread_ns or own
    columns = [*stream.inputs.values(), *(b.astype(float) for b in stream.bits.values())]
    rows = np.column_stack(columns)
    count = len(rows)
    given = place / "given.txt"
    kinds = "f" * len(stream.inputs) + "b" * len(stream.bits)
    with given.open("w", encoding="utf-8") as out:
        for row in rows.tolist():
            out.write(" ".join(repr(x) if k == "f" else str(int(x)) for k, x in zip(kinds, row, strict=True)) + "\n")
    outputs = hal.pins((p["name"], p["role"]) for p in manifest["outputs"])
    instance = f"{hal.component(manifest['name'])}.0"
    pins = [f"{instance}.{p}" for p in (*stream.inputs, *stream.bits)]
    sampled = [f"{instance}.{p}" for p in (*outputs, "fault-code")]
    sampled_kinds = "f" * len(outputs) + "s"
    lines = [
        f"loadrt threads name1=servo period1={thread}",
        f"loadrt streamer depth={count + 10} cfg={kinds}",
        f"loadrt sampler depth={count + 10} cfg={sampled_kinds}",
        f"loadrt {manifest['name']} count=1",
        *(f"addf {f} servo" for f in ("streamer.0", instance, "sampler.0")),
        *([f"setp {instance}.bumpless 0"] if manifest.get("bumpless") else []),
        *([] if "enable" in stream.bits else [f"setp {instance}.enable 1"]),
        *stream.setup,
        *(f"net in{i} streamer.0.pin.{i} => {pin}" for i, pin in enumerate(pins)),
        *(f"net out{i} {pin} => sampler.0.pin.{i}" for i, pin in enumerate(sampled)),
        f"loadusr -w halstreamer {given}",
        "start",
        *reading(place, count, sampled_kinds),
        *stream.after,
    ]
    printed = ran(place, lines, thread, count, speed)
    table = taken(place, len(sampled))
    return Replay(table[:, :-1].copy(), table[:, -1].astype(int), printed)


def reading(place: Path, count: int, kinds: str) -> list[str]:
    """The lines of a script that read the sampler's FIFO, exactly."""
    reader = place / "reader.py"
    reader.write_text(Path(hal_run.__file__).with_name("hal_reader.py").read_text(encoding="utf-8"), encoding="utf-8")
    return [f"loadusr -w {hal_run.PYTHON} {reader} {count} {kinds} {place / 'taken.bin'}"]


def ran(place: Path, lines: list[str], thread: int, count: int, speed: int) -> str:
    """What a script prints that takes some periods of a thread.

    On a busy machine HAL may not keep up with time that runs hundreds of times too fast: what fails then is done once
    more, ten times as slowly. What it computes does not depend on it.

    Raises:
        HalFailed: HAL did not run, or not to the end.
    """
    factor = max(speed, round(speed * thread / 1e6)) if speed > 1 else 1
    script = "\n".join(lines) + "\n"
    for slower in (factor, max(1, factor // 10)):
        fast = slower if hal_run.faketime() else 1
        try:
            return hal_run.run(place, script, slower, timeout=60.0 + 3.0 * count * thread * 1e-9 / fast)
        except hal_run.HalFailed:
            (place / "taken.bin").unlink(missing_ok=True)
            if fast == 1 or slower < factor:
                raise
    raise AssertionError("not reached")


def taken(place: Path, columns: int) -> np.ndarray:
    """What the sampler took, row by row.

    Raises:
        HalFailed: nothing.
    """
    file = place / "taken.bin"
    if not file.is_file():
        raise hal_run.HalFailed("halrun ended without samples")
    table = np.fromfile(file).reshape(-1, columns)
    file.unlink()
    return table


def _note(got: Replay, speed: int) -> str:
    """Who judged, and the first fault if there was one."""
    judge = f"LinuxCNC {hal_run.version()}"
    if not got.faults.any():
        return judge
    row = int(np.flatnonzero(got.faults)[0])
    return f"{judge}; fault {got.faults[row]} ({FAULTS.get(int(got.faults[row]), '')}) from row {row}"
