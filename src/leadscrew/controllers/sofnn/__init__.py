"""Fuzzy networks of a tangential knife: fixed, self-organising, and the standard self-organising fuzzy controller."""

from leadscrew.controllers.sofnn.fixed import fnn
from leadscrew.controllers.sofnn.network import sofnn
from leadscrew.controllers.sofnn.rules import with_network, with_rules
from leadscrew.controllers.sofnn.standard import sofc
from leadscrew.controllers.sofnn.tunings import TUNINGS

__all__ = ["TUNINGS", "fnn", "sofc", "sofnn", "with_network", "with_rules"]
