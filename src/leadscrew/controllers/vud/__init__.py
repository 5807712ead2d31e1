"""Controllers of the lathe axis of Long et al. (2014): variable universe of discourse, and what it is held against."""

from leadscrew.controllers.vud.duty_pd import duty_pd
from leadscrew.controllers.vud.duty_pd_observed import duty_pd_observed
from leadscrew.controllers.vud.duty_pid import duty_pid
from leadscrew.controllers.vud.error_factor import vud_beta_e
from leadscrew.controllers.vud.family import vud_family
from leadscrew.controllers.vud.fast import vud_fast
from leadscrew.controllers.vud.incremental import vud_incremental
from leadscrew.controllers.vud.integral_factor import vud_integral_factor
from leadscrew.controllers.vud.literal import vud
from leadscrew.controllers.vud.power_law import power_law
from leadscrew.controllers.vud.scaled import vud_scaled

__all__ = [
    "duty_pd",
    "duty_pd_observed",
    "duty_pid",
    "power_law",
    "vud",
    "vud_beta_e",
    "vud_family",
    "vud_fast",
    "vud_incremental",
    "vud_integral_factor",
    "vud_scaled",
]
