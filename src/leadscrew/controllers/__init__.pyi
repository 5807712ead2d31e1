from ._adaptive_resonant import adaptive_resonant as adaptive_resonant
from ._axis_cascade import axis_cascade as axis_cascade
from ._biquad import biquad as biquad
from ._cascade_ppi import cascade_ppi as cascade_ppi
from ._dead_zone_inverse import dead_zone_inverse as dead_zone_inverse
from ._feed_forward_table import feed_forward_table as feed_forward_table
from ._filters import lead_lag as lead_lag
from ._filters import low_pass as low_pass
from ._filters import notch as notch
from ._force import depth_feed_forward as depth_feed_forward
from ._force import gain_normalised as gain_normalised
from ._force.constant_force import constant_force as constant_force
from ._force.power_law_inversion import power_law_inversion as power_law_inversion
from ._friction_feed_forward import friction_feed_forward as friction_feed_forward
from ._grey_fuzzy.gpfc import gpfc as gpfc
from ._grey_fuzzy.pi_incremental import pi_incremental as pi_incremental
from ._grey_fuzzy.rules_shown import active_rules as active_rules
from ._grey_fuzzy.rules_shown import as_fuzzy_system as as_fuzzy_system
from ._grey_fuzzy.smith import smith as smith
from ._grey_fuzzy.tfc import tfc as tfc
from ._guard import (
    Clock as Clock,
)
from ._guard import (
    FeedCommand as FeedCommand,
)
from ._guard import (
    Levels as Levels,
)
from ._guard import (
    feed_override as feed_override,
)
from ._guard import (
    force_guard as force_guard,
)
from ._input_dob import input_dob as input_dob
from ._inverse_feed_forward import inverse_feed_forward as inverse_feed_forward
from ._lathe_loops import lathe_loops as lathe_loops
from ._learned_feed_forward import learned_feed_forward as learned_feed_forward
from ._look_ahead import look_ahead as look_ahead
from ._npid import npid as npid
from ._npid_after import npid_after as npid_after
from ._npid_slope import npid_slope as npid_slope
from ._npid_split import npid_split as npid_split
from ._parallel import PIDState as PIDState
from ._pd_dob import pd_dob as pd_dob
from ._pd_learned import pd_learned as pd_learned
from ._pid import PIDParams as PIDParams
from ._pid import pid as pid
from ._repetitive import repetitive as repetitive
from ._resonant import resonant as resonant
from ._response import PlantModel as PlantModel
from ._series import series as series
from ._sliding.complementary import csmc as csmc
from ._sliding.continuous import (
    csmc_ideal as csmc_ideal,
)
from ._sliding.continuous import (
    fsmc_ideal as fsmc_ideal,
)
from ._sliding.continuous import (
    fsmc_printed_ideal as fsmc_printed_ideal,
)
from ._sliding.continuous import (
    smc_ideal as smc_ideal,
)
from ._sliding.continuous import (
    smc_integral_ideal as smc_integral_ideal,
)
from ._sliding.conventional import smc as smc
from ._sliding.fuzzy import (
    fsmc as fsmc,
)
from ._sliding.fuzzy import (
    fsmc_printed as fsmc_printed,
)
from ._sliding.fuzzy import (
    fuzzy_sliding as fuzzy_sliding,
)
from ._sliding.fuzzy import (
    sliding_system as sliding_system,
)
from ._sliding.integral import smc_integral as smc_integral
from ._sliding.super_twisting import super_twisting as super_twisting
from ._sofnn.network import fnn as fnn
from ._sofnn.network import sofc as sofc
from ._sofnn.network import sofnn as sofnn
from ._sofnn.network import sofnn_all_weights as sofnn_all_weights
from ._sofnn.rules import with_network as with_network
from ._sofnn.rules import with_rules as with_rules
from ._tangent.curvature_feed_forward import curvature_feed_forward as curvature_feed_forward
from ._tangent.curvature_network import curvature_network as curvature_network
from ._tangent.tangent_dob import tangent_dob as tangent_dob
from ._tangent.taught_offset import taught_alone as taught_alone
from ._tangent.taught_offset import taught_offset as taught_offset
from ._torque_pid import torque_pid as torque_pid
from ._tracking_differentiator import tracking_differentiator as tracking_differentiator
from ._vud.duty_pd import duty_pd as duty_pd
from ._vud.duty_pd_observed import duty_pd_observed as duty_pd_observed
from ._vud.duty_pid import duty_pid as duty_pid
from ._vud.family import vud_family as vud_family
from ._vud.fast import vud_fast as vud_fast
from ._vud.power_law import power_law as power_law
from ._vud.printed import vud as vud
from ._vud.printed import vud_beta_e as vud_beta_e
from ._vud.printed import vud_incremental as vud_incremental
from ._vud.printed import vud_integral_factor as vud_integral_factor
from ._vud.scaled import vud_scaled as vud_scaled
