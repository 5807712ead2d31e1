from ._backlash import Play as Play
from ._backlash import backlash_axis as backlash_axis
from ._backlash import followed as followed
from ._backlash_two_mass import (
    backlash_two_mass as backlash_two_mass,
)
from ._backlash_two_mass import (
    damping_ratio as damping_ratio,
)
from ._backlash_two_mass import (
    restitution_of as restitution_of,
)
from ._ballscrew_axial import ballscrew_axial as ballscrew_axial
from ._ballscrew_backlash import ballscrew_backlash as ballscrew_backlash
from ._ballscrew_gms import ballscrew_gms as ballscrew_gms
from ._ballscrew_play import ballscrew_play as ballscrew_play
from ._ballscrew_play import play_in_motion as play_in_motion
from ._ballscrew_stage import TRAVEL_MM_PER_RAD as TRAVEL_MM_PER_RAD
from ._ballscrew_stage import ballscrew_stage as ballscrew_stage
from ._ballscrew_stage_fixed import ballscrew_stage_fixed as ballscrew_stage_fixed
from ._flexible_cut import flexible_cut as flexible_cut
from ._lathe_screw import lathe_screw as lathe_screw
from ._lathe_servo import lathe_servo as lathe_servo
from ._lathe_servo_limited import (
    LatheLimitedParams as LatheLimitedParams,
)
from ._lathe_servo_limited import (
    chain_matrices as chain_matrices,
)
from ._lathe_servo_limited import (
    lathe_servo_limited as lathe_servo_limited,
)
from ._linear import state_space as state_space
from ._linear import transfer_function as transfer_function
from ._mass_dahl import mass_dahl as mass_dahl
from ._mass_lugre import mass_lugre as mass_lugre
from ._mass_maxwell_slip import mass_maxwell_slip as mass_maxwell_slip
from ._mass_maxwell_slip import with_elements as with_elements
from ._mass_stribeck import mass_stribeck as mass_stribeck
from ._motor_data import (
    MOTOR_CONTINUOUS as MOTOR_CONTINUOUS,
)
from ._motor_data import (
    MOTOR_PEAK as MOTOR_PEAK,
)
from ._motor_data import (
    motor_constants as motor_constants,
)
from ._servo_axis import servo_axis as servo_axis
from ._servo_axis_lugre import servo_axis_lugre as servo_axis_lugre
from ._turning.process import turning as turning
from ._turning_lathe import turning_lathe as turning_lathe
from ._xy_table import xy_table as xy_table
from ._xy_table_cutting import xy_table_cutting as xy_table_cutting
from ._xy_table_lugre import xy_table_lugre as xy_table_lugre
from ._xy_table_two_mass import xy_table_two_mass as xy_table_two_mass
