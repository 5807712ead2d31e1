"""MATLAB ``.fis`` files: :func:`loads` and :func:`dumps`."""

from leadscrew.fuzzy.formats.fis_read import loads
from leadscrew.fuzzy.formats.fis_write import dumps

__all__ = ["dumps", "loads"]
