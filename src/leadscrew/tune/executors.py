"""Who does the work: the threads of this process, or a Dask cluster. Same chunks, same bits.

``threads`` chunks at a time run here, each on one thread (compiled loops hold no lock). ``cluster`` is ``local:N`` (N
worker processes on this machine) or the address of a scheduler (``tcp://HOST:PORT``, Dask distributed). A chunk
whose worker dies is done again by another.

Worker processes on this machine for a Dask scheduler: started by command line, ended with the block.

By command line and not by ``multiprocessing``, which would run the caller's script again in every worker, unless it has
a ``__main__`` guard. Each has a nanny that starts it again when it dies; all leave when their scheduler is gone.
"""

from __future__ import annotations

import contextlib
import os
import queue
import re
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any, Protocol

import numpy as np

from leadscrew import userfile
from leadscrew.kernel import validate
from leadscrew.tune.job import Chunk, Job
from leadscrew.util.errors import LeadscrewError, ValueRefused
from leadscrew.util.system import end_session, safe_path

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


Result = dict[str, np.ndarray]
DEATHS = 5
"""Workers that may die under the same chunk before it is given up."""
PATIENCE_S = 10.0
"""How long a scheduler may take to answer when it is met first."""
LOST_S = 60.0
"""How long it may be silent, or without any worker, while work is waited for."""
LOOK_S = 5.0
"""Without a result for so long, the scheduler is asked whether it is still there."""


class CrewLost(LeadscrewError):
    """Who did the work is gone; what was done is not."""


class Crew(Protocol):
    """Something that does chunks."""

    name: str

    def results(self, job: Job, chunks: Sequence[tuple[int, Chunk]]) -> Iterator[tuple[int, Result]]:
        """The results by number of the chunk, as they come."""
        ...


class Threads:
    """The threads of this process."""

    def __init__(self, threads: int | None = None) -> None:
        self.threads = validate.whole("threads", threads if threads is not None else os.cpu_count() or 1, 1, 1024)
        self.name = f"{self.threads} thread{'s' if self.threads > 1 else ''}"

    def results(self, job: Job, chunks: Sequence[tuple[int, Chunk]]) -> Iterator[tuple[int, Result]]:
        """The results as they come."""
        for scenario in {chunk.scenario for _, chunk in chunks}:
            job.compile(scenario)  # once, before the threads begin
        if self.threads == 1 or len(chunks) == 1:
            for number, chunk in chunks:
                yield number, job.run(chunk, threads=self.threads)
            return
        with ThreadPoolExecutor(self.threads) as pool:
            waiting = {pool.submit(job.run, chunk): number for number, chunk in chunks}
            try:
                for done in as_completed(waiting):
                    yield waiting[done], done.result()
            finally:
                pool.shutdown(wait=True, cancel_futures=True)


class Cluster:
    """A Dask cluster."""

    def __init__(self, client: Any, name: str) -> None:
        self.client, self.name = client, name
        self.alone_since: float | None = None

    def results(self, job: Job, chunks: Sequence[tuple[int, Chunk]]) -> Iterator[tuple[int, Result]]:
        """The results as they come; what a worker refuses is raised here.

        Raises:
            CrewLost: the scheduler or all workers are gone.
        """
        ready: queue.SimpleQueue[Any] = queue.SimpleQueue()
        futures: list[Any] = []
        try:
            with self._lost():
                for number, chunk in chunks:
                    futures.append(self.client.submit(work, job, number, chunk, pure=False, retries=0))
                    futures[-1].add_done_callback(ready.put)
            for _ in chunks:
                done = self._next(ready)
                if done.status == "error":
                    raise _refusal(done.exception(timeout=LOST_S))
                with self._lost():
                    number, result, refused = done.result(timeout=LOST_S)
                    done.release()
                if refused is not None:
                    raise refused
                yield number, result
        finally:
            with contextlib.suppress(Exception):
                self.client.cancel(futures)

    def _next(self, ready: queue.SimpleQueue[Any]) -> Any:
        """The next future that is done."""
        while True:
            try:
                return ready.get(timeout=LOOK_S)
            except queue.Empty:
                self._look()

    def _look(self) -> None:
        """Refuses to wait on where nobody works."""
        with self._lost():
            known = self.client.sync(self.client.scheduler.identity, callback_timeout=LOST_S)
        now = time.monotonic()
        self.alone_since = None if known["workers"] else self.alone_since or now
        if self.alone_since is not None and now - self.alone_since >= LOST_S:
            raise CrewLost(f"the Dask scheduler at {self.name} has lost all of its workers")

    @contextmanager
    def _lost(self) -> Iterator[None]:
        """What Dask raises when something is gone, as one sentence."""
        from distributed.client import CancelledError, ClosedClientError

        try:
            yield
        except (OSError, AttributeError, CancelledError, ClosedClientError) as error:
            raise CrewLost(f"the Dask scheduler at {self.name} is gone ({type(error).__name__})") from None


def _refusal(error: BaseException) -> BaseException:
    """What a worker could not do."""
    from distributed.scheduler import KilledWorker

    if isinstance(error, KilledWorker):
        return CrewLost(f"{DEATHS + 1} workers died under one piece of work: {error}")
    return error


def work(job: Job, number: int, chunk: Chunk) -> tuple[int, Result | None, LeadscrewError | None]:
    """What a worker does; its refusals come back as values, so that they keep their type and sentence.

    Whoever sent the job has built its loops, and so run the Python of its files, by the rule of its own working folder.
    """
    try:
        with userfile.trust():
            return number, job.run(chunk, threads=1), None
    except LeadscrewError as error:
        return number, None, type(error)(str(error))


@contextmanager
def crew(cluster: str | None = None, threads: int | None = None) -> Iterator[Crew]:
    """The crew that is asked for; what it started ends with the block.

    Raises:
        ValueRefused: an address that is none, or both ``cluster`` and ``threads``.
        LeadscrewError: Dask is not installed, or the scheduler does not answer.
    """
    if cluster is None:
        yield Threads(threads)
        return
    if threads is not None:
        raise ValueRefused("threads and cluster exclude each other; a cluster's workers run one chunk a thread")
    local = re.fullmatch(r"local:(\d+)", cluster)
    if not local and not re.fullmatch(r"(tcp|tls)://[^\s/:]+:\d+", cluster):
        raise ValueRefused(f"cluster = {cluster!r}: expected local:N or tcp://HOST:PORT")
    if local and not 1 <= int(local[1]) <= 1024:
        raise ValueRefused(f"cluster = {cluster!r}: allowed are 1 to 1024 workers")
    with _client(cluster, int(local[1]) if local else 0) as client:
        yield Cluster(client, cluster)


def _knock(address: str) -> None:
    """Raises an OSError where nothing listens, or nothing that greets as a scheduler does: Dask would wait for it."""
    kind, _, rest = address.partition("://")
    host, _, port = rest.rpartition(":")
    with socket.create_connection((host, int(port)), PATIENCE_S) as line:
        if kind == "tcp" and not line.recv(1):
            raise ConnectionError


def _greeted(address: str) -> Any:
    """A client of the scheduler; a busy one may send a message to all clients in the packet of its greeting, which
    Dask's client asserts to be alone.
    """
    import distributed

    for _ in range(2):
        with contextlib.suppress(AssertionError):
            return distributed.Client(address, timeout=PATIENCE_S)
    return distributed.Client(address, timeout=PATIENCE_S)


@contextmanager
def _client(address: str, workers: int) -> Iterator[Any]:
    try:
        import dask
        import distributed
    except ImportError:
        raise LeadscrewError("a cluster needs Dask: pip install 'leadscrew[cluster]'") from None
    settings = {
        "distributed.scheduler.allowed-failures": DEATHS,
        "distributed.comm.timeouts.connect": f"{PATIENCE_S:g}s",
        "distributed.admin.log-length": 0,
        "logging.distributed": "error",
    }
    with dask.config.set(settings):
        if not workers:
            try:
                _knock(address)
                client = _greeted(address)
            except (OSError, TimeoutError, OverflowError, AssertionError) as error:
                raise LeadscrewError(f"no Dask scheduler answers at {address} ({type(error).__name__})") from None
            try:
                client.wait_for_workers(1, timeout=PATIENCE_S)
            except TimeoutError:
                client.close()
                raise LeadscrewError(f"the Dask scheduler at {address} has no workers") from None
            try:
                yield client
            finally:
                with contextlib.suppress(OSError):
                    client.close(timeout=PATIENCE_S)
            return
        with (
            distributed.LocalCluster(
                n_workers=0,
                processes=False,
                protocol="tcp://",
                host="127.0.0.1",
                dashboard_address="127.0.0.1:0",  # with None it takes port 8787, and warns where that is taken
                silence_logs=40,
            ) as cluster,
            distributed.Client(cluster) as client,
            started(client, cluster.scheduler_address, workers),
        ):
            yield client
