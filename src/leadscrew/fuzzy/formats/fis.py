"""MATLAB ``.fis`` files: :func:`loads` and :func:`dumps`."""

from .fis_read import loads
from .fis_write import dumps

__all__ = ["dumps", "loads"]
