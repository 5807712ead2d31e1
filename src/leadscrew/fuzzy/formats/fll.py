"""fuzzylite's ``.fll`` files: :func:`loads` and :func:`dumps`."""

from leadscrew.fuzzy.formats.fll_read import loads
from leadscrew.fuzzy.formats.fll_write import dumps

__all__ = ["dumps", "loads"]
