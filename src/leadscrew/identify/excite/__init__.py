"""Test moves: what an axis must do so that its log tells mass, friction, delay and lost motion, inside safe limits."""

from leadscrew.util.lazy_exports import exports

__getattr__, __dir__, __all__ = exports(__name__, __file__)
