from ._chirp import chirp as chirp
from ._chirp import log_chirp as log_chirp
from ._cut_line import TangentCommand as TangentCommand
from ._cut_line import along as along
from ._cut_line import cut_line as cut_line
from ._cutting_program import (
    NEVER_S as NEVER_S,
)
from ._cutting_program import (
    CutCommand as CutCommand,
)
from ._cutting_program import (
    cutting_force as cutting_force,
)
from ._cutting_program import (
    cutting_program as cutting_program,
)
from ._eased_sine import eased_sine as eased_sine
from ._eased_sine import eased_sine_motion as eased_sine_motion
from ._filtered_step import filtered_step as filtered_step
from ._friction_test import friction_test as friction_test
from ._friction_test import friction_test_duration as friction_test_duration
from ._gcode import path_from_gcode as path_from_gcode
from ._lathe_program import lathe_program as lathe_program
from ._logged import logged_command as logged_command
from ._motion import Motion as Motion
from ._path import PathPoint as PathPoint
from ._path import Segment as Segment
from ._path import arc as arc
from ._path import line as line
from ._path import path as path
from ._quintic import quintic as quintic
from ._ramp import ramp as ramp
from ._ramp import ramp_motion as ramp_motion
from ._s_curve import s_curve as s_curve
from ._sine import sine as sine
from ._sine import sine_motion as sine_motion
from ._stairs import stairs as stairs
from ._step import step as step
from ._trapezoid import trapezoid as trapezoid
from ._waypoints import waypoints as waypoints
