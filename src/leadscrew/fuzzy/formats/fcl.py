"""IEC 61131-7 fuzzy control language, ``.fcl``: :func:`loads` and :func:`dumps`."""

from .fcl_read import loads
from .fcl_write import dumps

__all__ = ["dumps", "loads"]
