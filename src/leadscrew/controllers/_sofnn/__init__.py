"""Fuzzy networks of a tangential knife: fixed, self-organising, and the standard self-organising fuzzy controller."""

from leadscrew.controllers._sofnn.network import fnn, sofc, sofnn, sofnn_all_weights
from leadscrew.controllers._sofnn.rules import with_network, with_rules

__all__ = ["fnn", "sofc", "sofnn", "sofnn_all_weights", "with_network", "with_rules"]
