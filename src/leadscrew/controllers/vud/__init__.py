"""Controllers of the lathe axis of Long et al. (2014): variable universe of discourse, and what it is held against."""

from leadscrew.controllers.vud.duty_pd import duty_pd
from leadscrew.controllers.vud.error_factor import vud_beta_e
from leadscrew.controllers.vud.literal import vud
from leadscrew.controllers.vud.power_law import power_law

__all__ = ["duty_pd", "power_law", "vud", "vud_beta_e"]
