"""One lab of the XY table study for all tests of a process: what one of them measures the others have."""

from functools import cache

from leadscrew import resolve
from leadscrew.studies.lab import Lab


@cache
def lab() -> Lab:
    return Lab(resolve.study("npid_xytable"))
