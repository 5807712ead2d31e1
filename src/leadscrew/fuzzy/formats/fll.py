"""fuzzylite's ``.fll`` files: :func:`loads` and :func:`dumps`."""

from .fll_read import loads
from .fll_write import dumps

__all__ = ["dumps", "loads"]
