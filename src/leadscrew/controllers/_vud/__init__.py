"""Controllers of the lathe axis of Long et al. (2014): variable universe of discourse, and what it is held against."""

from leadscrew.controllers._vud.duty_pd import duty_pd
from leadscrew.controllers._vud.duty_pd_observed import duty_pd_observed
from leadscrew.controllers._vud.duty_pid import duty_pid
from leadscrew.controllers._vud.family import vud_family
from leadscrew.controllers._vud.fast import vud_fast
from leadscrew.controllers._vud.power_law import power_law
from leadscrew.controllers._vud.printed import vud, vud_beta_e, vud_incremental, vud_integral_factor
from leadscrew.controllers._vud.scaled import vud_scaled

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
