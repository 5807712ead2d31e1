"""IEC 61131-7 fuzzy control language, ``.fcl``: :func:`loads` and :func:`dumps`."""

from leadscrew.fuzzy.formats.fcl_read import loads
from leadscrew.fuzzy.formats.fcl_write import dumps

__all__ = ["dumps", "loads"]
