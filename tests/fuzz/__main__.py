"""Changed files before every reader: ``python -m tests.fuzz --inputs 20000 --first 0``.

Each reader works in a process of its own. What counts as a fault: an error that is no sentence, a process that dies, a
file that takes more than 20 s, or memory above 2 GiB. Faults are printed and their files kept; exit code 1.
"""

from __future__ import annotations

import argparse
import os
import queue
import resource
import subprocess
import sys
import tempfile
import threading
import time
import traceback
from pathlib import Path

from tests.fuzz.one import made, tried
from tests.fuzz.targets import Target, targets

SECONDS, BYTES = 20.0, 2 * 1024**3


def work(name: str, first: int, count: int) -> None:
    """In a process: says the number of each file before it is read, and what came of it."""
    target = next(t for t in targets() if t.name == name)
    for seed in range(first, first + count):
        with tempfile.TemporaryDirectory() as folder:
            path = made(target, seed, Path(folder))
            print(f"begin {seed}", flush=True)
            began = time.perf_counter()
            try:
                said = tried(target, path)
            except BaseException:
                said = "fault " + traceback.format_exc().replace("\n", "\\n")
            held = max(resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
            print(f"end {time.perf_counter() - began:.2f} {held * 1024} {said}", flush=True)


def watched(target: Target, first: int, count: int, faults: list[str]) -> tuple[int, int, float, int]:
    """Read, refused, longest time and most memory of the files of one reader."""
    seen, refused, longest, most, at = 0, 0, 0.0, 0, first
    while at < first + count:
        command = [sys.executable, "-m", "tests.fuzz", "--work", target.name, str(at), str(first + count - at)]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        lines: queue.Queue[str] = queue.Queue()

        def pump(process: subprocess.Popen[str] = process, lines: queue.Queue[str] = lines) -> None:
            assert process.stdout is not None
            for line in process.stdout:
                lines.put(line)
            lines.put("")

        threading.Thread(target=pump, daemon=True).start()
        limit = 120.0  # to start
        while True:
            try:
                line = lines.get(timeout=limit)
            except queue.Empty:
                process.kill()
                faults.append(f"{target.name} {at}: took more than {limit:.0f} s")
                at += 1
                break
            if not line:
                if process.wait() or at < first + count:
                    faults.append(f"{target.name} {at}: its process died with {process.returncode}")
                    at += 1
                break
            limit = SECONDS
            if line.startswith("end "):
                _, seconds, held, said = line.rstrip("\n").split(" ", 3)
                longest, most = max(longest, float(seconds)), max(most, int(held))
                seen, refused = seen + 1, refused + (said == "refused")
                if said.startswith("fault"):
                    faults.append(f"{target.name} {at}: {said[6:]}")
                if int(held) > BYTES:
                    faults.append(f"{target.name} {at}: held {int(held) / 1024**3:.1f} GiB")
                    process.kill()
                at += 1
    return seen, refused, longest, most


def main() -> int:
    """Exit code 1 where there are faults."""
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    parser.add_argument("--inputs", type=int, default=2000, help="how many files, over all readers")
    parser.add_argument("--first", type=int, default=0, help="number of the first file of each reader")
    parser.add_argument("--only", default="", help="readers whose name has this")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--keep", type=Path, default=Path("fuzz-faults"), help="where files with faults are put")
    parser.add_argument("--work", nargs=3, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.work:
        work(asked.work[0], int(asked.work[1]), int(asked.work[2]))
        return 0
    chosen = [t for t in targets() if asked.only in t.name]
    whole = sum(t.weight for t in chosen)
    waiting: queue.Queue[tuple[Target, int]] = queue.Queue()
    for target in sorted(chosen, key=lambda t: t.weight):
        waiting.put((target, -(-asked.inputs * target.weight // whole)))
    faults: list[str] = []
    total = [0]

    def worker() -> None:
        while True:
            try:
                target, count = waiting.get_nowait()
            except queue.Empty:
                return
            seen, refused, longest, most = watched(target, asked.first, count, faults)
            total[0] += seen
            print(
                f"{target.name:24} {seen:6} files, {refused:6} refused, at most {longest:5.1f} s, "
                f"{most / 1024**2:5.0f} MiB", flush=True,
            )  # fmt: skip

    threads = [threading.Thread(target=worker) for _ in range(asked.jobs)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for fault in faults:
        name, _, number = fault.partition(":")[0].rpartition(" ")
        folder = asked.keep / f"{name.replace(' ', '_')}-{number}"
        folder.mkdir(parents=True, exist_ok=True)
        made(next(t for t in targets() if t.name == name), int(number), folder)
        print(f"\n{folder}: " + fault.replace("\\n", "\n"))
    print(f"{total[0]} files, seeds {asked.first} and on, {len(faults)} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
