"""A piece of this program in a process of its own, for what may crash, hang or fill the memory: broken files read."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from leadscrew.kernel.errors import DataError, LeadscrewError

SECONDS, BYTES, REFUSED = 45, 4_000_000_000, 3
"""Most time and address space of the process, and its exit code where it refused the file."""


def run(module: str, path: Path, out: Path) -> None:
    """Runs ``module.apart(path, out)`` in a process of its own.

    Raises:
        DataError: it refused the file, crashed, took more than 45 s or more memory than it may.
    """
    code = f"import sys; from leadscrew.logs import apart; apart.main({module!r}, *sys.argv[1:])"
    environment = {
        **os.environ,
        "OPENBLAS_NUM_THREADS": "1",
        "PYTHONPATH": os.pathsep.join(p for p in sys.path if p),
    }
    command = [sys.executable, "-c", code, str(path), str(out)]
    try:
        done = subprocess.run(
            command, capture_output=True, timeout=SECONDS, env=environment, check=False, stdin=subprocess.DEVNULL
        )
    except subprocess.TimeoutExpired:
        raise DataError(f"{path}: was not read after {SECONDS} s; cut it into parts, or save it as Parquet") from None
    if done.returncode == REFUSED:
        raise DataError(done.stderr.decode("utf-8", "replace").strip())
    if done.returncode or not out.is_file():
        raise DataError(f"{path}: is broken so that its reader crashes; save it again, or as CSV")


def main(module: str, path: str, out: str) -> None:
    """What the process does: a refusal goes to the standard error."""
    import importlib

    _bounded()
    try:
        importlib.import_module(module).apart(Path(path), Path(out))
    except LeadscrewError as refused:
        sys.stderr.write(str(refused))
        raise SystemExit(REFUSED) from None


def _bounded() -> None:
    """Bounds on memory and computing where the system has them."""
    try:
        import resource
    except ImportError:
        return
    resource.setrlimit(resource.RLIMIT_AS, (BYTES, BYTES))
    resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS))


__all__ = ["REFUSED", "main", "run"]
