"""Claims of this study in few words, see :mod:`leadscrew.studies.saying`."""

from __future__ import annotations

from functools import partial

from leadscrew.studies.saying import claim_of, verdict_of, word

__all__ = ["said", "verdict_of", "word"]

said = partial(claim_of, "sofnn_tangent")
