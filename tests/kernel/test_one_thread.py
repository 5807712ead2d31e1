"""Linear algebra on one thread: in a process of its own, whose BLAS has two."""

import os
import subprocess
import sys

PROGRAM = """
import scipy.linalg, threadpoolctl
from leadscrew.kernel.one_thread import one_thread
def threads():
    return sorted({i["num_threads"] for i in threadpoolctl.threadpool_info() if i["user_api"] == "blas"})
@one_thread()
def inside():
    return threads()
print(threads())
for _ in range(2):
    with one_thread():
        print(threads())
    print(inside())
try:
    with one_thread():
        raise ValueError
except ValueError:
    print(threads())
"""


def test_every_blas_has_one_thread_inside_and_its_own_number_before_and_after():
    two = {**os.environ, "OPENBLAS_NUM_THREADS": "2", "MKL_NUM_THREADS": "2"}
    done = subprocess.run([sys.executable, "-c", PROGRAM], env=two, capture_output=True, text=True, timeout=60)
    assert done.stderr == "" and done.stdout.split("\n") == ["[2]", "[1]", "[1]", "[1]", "[1]", "[2]", ""]
