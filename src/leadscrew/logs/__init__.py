"""Logs of machines: what a file holds, which column is what, and what is wrong with it, said before anything is fitted.

:func:`read_table` reads a file as it is; :func:`read_axis_log` makes the log of one axis of it, in SI units and evenly
sampled; :func:`axis_log` does so from arrays. The user's data are never changed, neither the file nor the arrays.
"""

from leadscrew.util.lazy_exports import exports

__getattr__, __dir__, __all__ = exports(__name__, __file__)
