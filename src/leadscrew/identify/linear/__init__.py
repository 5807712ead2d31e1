"""Linear models from logs: a transfer function with delay, its order chosen by simulation of validation data.

:func:`identify_linear` takes arrays, :func:`read_linear` makes them from two columns of a log.
"""

from leadscrew.util.lazy_exports import exports

__getattr__, __dir__, __all__ = exports(__name__, __file__)
