"""The stage under a PID without a model."""

from leadscrew.controllers._torque_pid import torque_pid
from tests.controllers.stage_loop import stage_loop


def pid():
    return stage_loop(
        torque_pid(kp=300.0, ki=50_000.0, kd=0.9, filter_s=8e-5, lower=-40.0, upper=40.0), encoder_mm=1e-5
    )
