"""Files read in a process of its own, because a broken one may crash its reader, hang it, or fill the memory.

A reader is a module with a function ``apart(path, out)``, which reads ``path`` and writes what it holds to ``out`` in a
form that is safe to read. The process is kept for the next file; several files at once have several processes.
"""

from __future__ import annotations

import atexit
import contextlib
import json
import os
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

from leadscrew.util import reading, system
from leadscrew.util.errors import DataError, LeadscrewError

SECONDS, BYTES = 45, 4_000_000_000
"""Most time for a file, and most address space of the process."""
RETIRES = 1000.0
"""A process that has held so many MiB is not kept."""

_idle: list[_Process] = []


RUN = "from leadscrew.util import separate_process; separate_process.main()"


def run(module: str, path: Path, out: Path) -> None:
    """Runs ``module.apart(path, out)`` in a process of its own.

    Raises:
        DataError: it refused the file, crashed, took more than 45 s or more memory than it may.
    """
    process = _take()
    try:
        said = process.ask({"module": module, "path": str(path), "out": str(out), "folder": str(Path.cwd())})
    except BaseException:
        process.kill()
        raise
    if said is None:
        late = process.late
        process.kill()
        if late:
            raise DataError(
                f"{path}: was not read after {process.seconds:g} s; cut it into parts, or {reading.how_to_raise(2)}"
            )
        raise DataError(f"{path}: is broken so that its reader crashes; save it again, or as CSV")
    if said["kept"]:
        _idle.append(process)
    else:
        process.kill()
    if said["refused"] is not None:
        raise DataError(str(said["refused"]))
    if not out.is_file():
        raise DataError(f"{path}: cannot be read")


def _take() -> _Process:
    """A process that waits, or a new one."""
    factor = reading.factor()
    while _idle:
        process = _idle.pop()
        if process.factor == factor and process.child.poll() is None:
            return process
        process.kill()
    return _Process(factor)


class _Process:
    """A process that reads one file after the other."""

    def __init__(self, factor: float) -> None:
        self.factor = factor
        self.seconds = SECONDS * factor
        self.late = False
        environment = {
            **os.environ,
            "OPENBLAS_NUM_THREADS": "1",
            "PYTHONPATH": os.pathsep.join(str(Path(p).resolve()) for p in sys.path if p),
        }
        self.child = subprocess.Popen(
            [sys.executable, *system.safe_path(), "-c", RUN], env=environment,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
        )  # fmt: skip

    def ask(self, job: dict[str, str]) -> dict[str, Any] | None:
        """What the process says of a job; None where it died of it, or was killed for its time."""
        assert self.child.stdin is not None
        assert self.child.stdout is not None
        timer = threading.Timer(self.seconds, self._too_late)
        timer.start()
        try:
            self.child.stdin.write(json.dumps(job).encode() + b"\n")
            self.child.stdin.flush()
            line = self.child.stdout.readline()
        except OSError:
            line = b""
        finally:
            timer.cancel()
        return json.loads(line) if line.endswith(b"\n") else None

    def _too_late(self) -> None:
        self.late = True
        self.child.kill()

    def kill(self) -> None:
        """Ends it and gives its pipes back."""
        self.child.kill()
        self.child.wait()
        for pipe in (self.child.stdin, self.child.stdout):
            with contextlib.suppress(OSError, AttributeError):
                pipe.close()  # type: ignore[union-attr]


@atexit.register
def _end() -> None:
    while _idle:
        _idle.pop().kill()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_idle.clear)  # its pipes are the parent's


# ---- in the process
def main() -> None:
    """One file after the other: a job comes as a line of JSON, a line of JSON is the answer."""
    system.ignore_interrupt()  # it ends the one who asks, which ends this process
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # what a library prints is no answer
    for line in sys.stdin.buffer:
        job = json.loads(line)
        system.bound(int(BYTES * reading.factor()), SECONDS * reading.factor())
        refused = _refused(job)
        kept = (system.peak_memory() or 0.0) < RETIRES
        answers.write(json.dumps({"refused": refused, "kept": kept}).encode() + b"\n")
        answers.flush()


def _refused(job: dict[str, str]) -> str | None:
    import importlib

    try:
        os.chdir(job["folder"])
        importlib.import_module(job["module"]).apart(Path(job["path"]), Path(job["out"]))
    except LeadscrewError as refused:
        return str(refused)
    except MemoryError:
        return f"{job['path']}: asks for more memory than {BYTES * reading.factor() / 1e9:.0f} GB; is it broken?"
    return None


__all__ = ["main", "run"]
