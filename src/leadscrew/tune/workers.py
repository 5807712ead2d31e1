"""Worker processes on this machine for a Dask scheduler: started by command line, ended with the block.

By command line and not by ``multiprocessing``, which would run the caller's script again in every worker, unless it has
a ``__main__`` guard. Each has a nanny that starts it again when it dies; all leave when their scheduler is gone.
"""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

from leadscrew.kernel.errors import LeadscrewError
from leadscrew.kernel.system import end_session, safe_path

START_S = 90.0
"""How long workers may take to start, all together."""
END_S = 5.0
"""How long they may take to leave, before they are ended."""


@contextmanager
def started(client: Any, address: str, count: int) -> Iterator[None]:
    """``count`` worker processes of one thread for a scheduler; ready when the block begins.

    Raises:
        LeadscrewError: they do not start; the last thing that they said.
    """
    command = [
        sys.executable, *safe_path(), "-m", "distributed.cli.dask_worker", address,
        "--nworkers", str(count), "--nthreads", "1",
        "--host", "127.0.0.1", "--no-dashboard", "--death-timeout", f"{START_S:g}",
    ]  # fmt: skip
    known = {**os.environ, "PYTHONPATH": os.pathsep.join(p or str(Path.cwd()) for p in sys.path)}
    with tempfile.TemporaryFile() as said:
        # A session of their own: Ctrl-C is for the process that started them.
        running = subprocess.Popen(command, stdout=said, stderr=said, env=known, start_new_session=True)
        try:
            _wait(client, running, count, said)
            yield
        finally:
            _end(running)


def _wait(client: Any, running: subprocess.Popen[bytes], count: int, said: IO[bytes]) -> None:
    for _ in range(int(START_S)):
        with contextlib.suppress(TimeoutError):
            client.wait_for_workers(count, timeout=1.0)
            return
        if running.poll() is not None:
            break
    said.seek(0)
    last = (said.read().decode(errors="replace").strip().splitlines() or ["they said nothing"])[-1]
    raise LeadscrewError(f"the {count} workers on this machine did not start: {last}")


def _end(running: subprocess.Popen[bytes]) -> None:
    """Asks them to leave, and ends what is left."""
    running.terminate()
    with contextlib.suppress(subprocess.TimeoutExpired):
        running.wait(END_S)
    end_session(running)
    running.wait()
