"""Linear models from logs: a transfer function with delay, its order chosen by simulation of what it has not seen.

:func:`identify_linear` takes arrays, :func:`read_linear` makes them from two columns of a log.
"""

from leadscrew.lazy import doors

__getattr__, __dir__ = doors(
    globals(),
    {
        "record": "LinearRecord linear_record read_linear",
        "fit": "identify_linear",
        "result": "LinearFit Candidate Interval Stretch machine machine_values block",
        "servo_gain": "servo_gain read_moves",
    },
)
