"""Search and uncertainty: distributions over parameters, many runs anywhere, tuning, comparison, Monte Carlo.

Public here are ``tune``, ``Job`` and ``Space``. ``compare`` and ``montecarlo`` are modules of this package; their
functions are :func:`leadscrew.compare` and :func:`leadscrew.montecarlo`.
"""

from leadscrew.util.lazy_exports import exports

__getattr__, __dir__, __all__ = exports(__name__, __file__)
