"""Linear algebra on one thread: on small or narrow matrices the threads of BLAS only wait for each other."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def one_thread() -> Iterator[None]:
    """Inside it, or in a function that it decorates, BLAS takes one thread; on a busy machine 0.05 ms in place of 2."""
    import scipy.linalg  # noqa: F401  its BLAS is another one than NumPy's, and only what is there is limited
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1):
        yield
