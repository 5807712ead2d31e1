"""The grating ruler of Long et al. (2014), section III: from the fringe to the count, one file a part.

======================  ===========================================================================================
``moire``               width of the moire fringe, (1), and the data of the grating
``quadrature``          the two signals of the photo-transistors with their errors, and the position error that follows
``counting``            comparators, code, direction and reversible counter, for arrays; the slowest sampling allowed
``counter``             the same as a block: ``grating_counter``, for loops that sample faster than the counts come
``ruler``               the count worked out in one go: ``grating_ruler``, for loops of 1 ms
======================  ===========================================================================================
"""

from leadscrew.util.lazy_exports import exports

__getattr__, __dir__, __all__ = exports(__name__, __file__)
