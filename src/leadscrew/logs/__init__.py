"""Logs of machines: what a file holds, which column is what, and what is wrong with it, said before anything is fitted.

:func:`read_table` reads a file as it is; :func:`read_axis_log` makes the log of one axis of it, in SI units and evenly
sampled; :func:`axis_log` does so from arrays. The user's data are never changed, neither the file nor the arrays.
"""

from leadscrew.lazy import doors

__getattr__, __dir__ = doors(
    globals(),
    {
        "arrays": "AxisLog LogUnits axis_log",
        "axis_file": "Seen read_axis_log look_at",
        "finding": "Finding",
        "read": "read_table",
        "table": "Table",
    },
)
