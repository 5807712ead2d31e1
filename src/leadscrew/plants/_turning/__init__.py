"""Turning: feed servo, chip and cutting force.

The block is :data:`leadscrew.plants.turning`; it and what it shows can be imported from here.
"""

from leadscrew.plants._turning.process import Turned, TurningParams, TurningState, turning

__all__ = ["Turned", "TurningParams", "TurningState", "turning"]
