"""Trees are made by one thread at a time: CPython 3.11 fails where two make them at once."""

import gc
import time
from concurrent.futures import ThreadPoolExecutor

from leadscrew.kernel.trees import code_of, expression, parsed

TEXT = "\n".join(f"x{i} = (a + {i}) * (b - {i}) if c[{i}] > 0 else f(a, {i})" for i in range(100))


def test_threads_make_trees_while_the_garbage_collector_calls_python():
    def made(k):
        code_of(parsed(TEXT), "trees.py")
        return expression(f"{k} + 1").left.value

    before = gc.get_threshold()
    gc.callbacks.append(pause := lambda phase, info: time.sleep(1e-5))
    gc.set_threshold(50)
    try:
        with ThreadPoolExecutor(4) as threads:
            assert list(threads.map(made, range(16))) == list(range(16))
    finally:
        gc.set_threshold(*before)
        gc.callbacks.remove(pause)
