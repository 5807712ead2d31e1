"""Control of the cutting force beyond the fuzzy rules: what knows the programme, and what learns the cutting law.

Wrappers of any incremental controller: :func:`depth_feed_forward`, :func:`gain_normalised`. Controllers:
:data:`power_law_inversion`, :data:`constant_force`.
"""

from leadscrew.controllers._force.constant_force import constant_force
from leadscrew.controllers._force.depth_feed_forward import depth_feed_forward
from leadscrew.controllers._force.gain_normalised import gain_normalised
from leadscrew.controllers._force.power_law_inversion import power_law_inversion

__all__ = ["constant_force", "depth_feed_forward", "gain_normalised", "power_law_inversion"]
