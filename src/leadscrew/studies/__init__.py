"""Studies of published systems: ``from leadscrew.studies import Study, claim, measure`` and what else a study takes."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
