"""Fuzzy networks of a tangential knife: fixed, self-organising, and the standard self-organising fuzzy controller."""

from leadscrew.controllers._sofnn.fixed import fnn
from leadscrew.controllers._sofnn.network import sofnn
from leadscrew.controllers._sofnn.rules import with_network, with_rules
from leadscrew.controllers._sofnn.standard import sofc

__all__ = ["fnn", "sofc", "sofnn", "with_network", "with_rules"]
