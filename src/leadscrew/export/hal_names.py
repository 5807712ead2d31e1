"""The names that a controller has in LinuxCNC's HAL: its component, its pins, its parameters."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence

from leadscrew.kernel.errors import ValueRefused

LONGEST = 47
"""HAL_NAME_LEN of LinuxCNC 2.9."""

BY_ROLE = ("command", "feedback", "output", "command-deriv", "command-accel")
FIXED = (
    *BY_ROLE,
    "error",
    "enable",
    "index-enable",
    "saturated",
    "fault",
    "fault-code",
    "bad-parameter",
    "maxoutput",
    "max-following-error",
    "max-wrong-way",
    "period-design",
    "every",
    "rediscretise",
    "inside",
    "time",
    "tmax",
    "tmax-increased",
)
"""Names that the component or HAL itself uses, whether this controller has them or not."""

_STOCK = """abs abs_s32 and2 anglejog axistest bin2gray biquad bitslice bitwise bldc blend boss_plc carousel charge_pump
    clarke2 clarke3 clarkeinv classicladder_rt comp constant conv_bit_float conv_bit_s32 conv_bit_u32
    conv_float_s32 conv_float_u32 conv_s32_bit conv_s32_float conv_s32_u32 conv_u32_bit conv_u32_float
    conv_u32_s32 corexy_by_hal corexykins counter dbounce ddt deadzone debounce demux differential div2 edge
    encoder encoder_ratio eoffset_per_angle estop_latch feedcomp filter_kalman flipflop gantry gearchange
    genhexkins genserkins gray2bin hal_bb_gpio hal_gm hal_lib hal_parport hal_pi_gpio hal_ppmc hal_speaker
    histobins hm2_7i43 hm2_7i90 hm2_eth hm2_pci hm2_rpspi hm2_spi hm2_test homecomp homemod hostmot2 hypot
    ilowpass integ invert joyhandle knob2float latencybins lcd limit1 limit2 limit3 lincurve lineardeltakins
    logic lowpass lut5 maj3 match8 matrix_kb max31855 maxkins mesa_7i65 mesa_pktgyro_test mesa_uart message
    millturn minmax modmath motmod moveoff mult2 multiclick multiswitch mux16 mux2 mux4 mux8 mux_generic near
    not offset ohmic oneshot or2 orient pentakins pid plasmac pumakins pwmgen rosekins rotarydeltakins
    rotatekins sample_hold sampler scale scaled_s32_sums scarakins scope_rt select8 serport setsserial siggen
    sim_axis_hardware sim_encoder sim_home_switch sim_matrix_kb sim_parport sim_spindle simple_tp sphereprobe
    spindle spindle_monitor stepgen steptest streamer sum2 supply thc thcud threads threadtest time timedelay
    timedelta tof toggle toggle2nist ton tp tpmod tripodkins tristate_bit tristate_float trivkins updown
    userkins watchdog wcomp weighted_sum xhc_hb04_util xor2 xyzab_tdr_kins"""
STOCK = frozenset(_STOCK.split())
"""The realtime components of LinuxCNC 2.9, and what else is in its folder of modules."""


def component(name: str) -> str:
    """The component's name in HAL: ``demo_pd`` is ``demo-pd``, its first instance ``demo-pd.0``."""
    return name.removeprefix("hal_").replace("_", "-").rstrip("-")


def _free(name: str, prefix: str, taken: set[str]) -> str:
    """The name with dashes for underscores, behind the prefix where it is taken."""
    free = re.sub("_+", "-", name).strip("-")
    while free in taken:
        free = f"{prefix}-{free}"
    taken.add(free)
    return free


def pins(ports: Iterable[tuple[str, str]]) -> list[str]:
    """Names of the pins of inputs or outputs, given each one's C identifier and role."""
    taken = set(FIXED)
    used: set[str] = set()

    def named() -> Iterator[str]:
        for name, role in ports:
            if role in BY_ROLE and role not in used:
                used.add(role)
                yield role
            else:
                yield _free(name, "pin", taken)

    return list(named())


def parameters(knobs: Iterable[str], others: Iterable[str]) -> list[str]:
    """Names of the parameters of knobs, given their C identifiers and the pins' names."""
    taken = {*FIXED, *others}
    return [_free(k, "knob", taken) for k in knobs]


def new(name: str) -> None:
    """Refuses the name of a component that LinuxCNC has: installing ours would replace it.

    Raises:
        ValueRefused: there is one of that name.
    """
    if name in STOCK:
        raise ValueRefused(
            f"name = {name!r} is a component of LinuxCNC, which this one would replace; choose another, "
            f"for example --name {name}_controller"
        )


def fit(name: str, within: Sequence[str]) -> None:
    """Refuses a component whose pins would not fit into a HAL name.

    Raises:
        ValueRefused: a name is too long.
    """
    longest = max(within, key=len)
    full = f"{component(name)}.0.{longest}"
    if len(full) > LONGEST:
        raise ValueRefused(
            f"{full} has {len(full)} characters, and LinuxCNC allows names of {LONGEST}: "
            f"export under a name that is {len(full) - LONGEST} characters shorter than {name}"
        )
