"""LinuxCNC: the controller as a HAL component in place of ``pid``, with an example and a demonstration."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from leadscrew.export.core import Core, Knob, Port
from leadscrew.export.machine import LICENCE, number
from leadscrew.export.templates import render
from leadscrew.figures.formats import integrated
from leadscrew.util.errors import ValueRefused
from leadscrew.util.escape import hal_string

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

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


def check_name(name: str) -> None:
    """Refuses the name of a component that LinuxCNC has: installing ours would replace it.

    Raises:
        ValueRefused: there is one of that name.
    """
    if name in STOCK:
        raise ValueRefused(
            f"name = {name!r} is a component of LinuxCNC, which this one would replace; choose another, "
            f"for example --name {name}_controller"
        )


def check_lengths(name: str, within: Sequence[str]) -> None:
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


S32 = (-(2**31), 2**31 - 1)
LENGTHS = {"mm": 1.0, "um": 1000.0, "m": 0.001}
"""How many of a unit make a millimetre."""


@dataclass(frozen=True)
class Pin:
    """An input or output as a HAL pin."""

    hal: str
    """Name in HAL."""
    c: str
    """Name in the component's C."""
    name: str
    """C identifier in the machine layer."""
    unit: str
    doc: str
    about: str
    """What it is, with its unit."""
    start: float = 0.0
    """What an input holds while nothing is connected to it."""


@dataclass(frozen=True)
class Setting:
    """A number that can be set in HAL: a knob or a limit."""

    hal: str
    c: str
    hal_type: str
    start: str
    """Its value as exported, for halcompile."""
    unit: str
    doc: str
    about: str
    """What it is, with its unit and range."""
    range: str
    held_type: str
    wanted: str
    """C that reads it, in the type it is held in."""
    outside: str
    """C that tells whether it is out of range."""
    places: tuple[str, ...]
    """Where it goes, below the machine."""


def files(core: Core) -> dict[str, str]:
    """The component, its header, an example of use and a demonstration that runs without hardware.

    Raises:
        ValueRefused: a name is too long for HAL, or that of a component of LinuxCNC.
    """
    check_name(core.name)
    view = _view(core)
    check_lengths(core.name, [p.hal for p in (*view["inputs"], *view["outputs"], *view["settings"])])
    check_lengths(core.name, FIXED)
    n = core.name
    return {
        f"{n}.comp": render("hal_comp.j2", **view),
        f"{n}_hal.h": render("hal_header.j2", **view),
        f"{n}_example.hal": render("hal_example.j2", **view),
        f"{n}_sim.hal": render("hal_sim.j2", **view),
    }


def readme(core: Core, machine: Loop | None = None) -> str:
    """The LinuxCNC section of the README, as Markdown; ``machine``: the loop whose simulated machine comes with it."""
    by = integrated(machine.integration) if machine is not None else ""
    varies = machine is not None and machine.integration["method"] == "rodas"
    return render("hal_readme.j2", **_view(core), machine=machine is not None, integrated=by, varies=varies)


def _view(core: Core) -> dict[str, Any]:
    """What the templates are filled in with."""
    inputs, outputs = _pins(core.inputs), _pins(core.outputs)
    taken = [p.hal for p in (*inputs, *outputs)]
    names = parameters([k.name for k in core.knobs], taken)
    knobs = [_knob(core, k, name) for k, name in zip(core.knobs, names, strict=True)]
    derived = [p for p in inputs if p.hal in ("command-deriv", "command-accel")]
    return {
        "core": core,
        "n": core.name,
        "comp": component(core.name),
        "licence": LICENCE,
        "inputs": inputs,
        "outputs": outputs,
        "derived": derived,
        "derived_names": [p.hal for p in derived],
        "knobs": knobs,
        "settings": [*_limits(core), *knobs],
        "limits": core.limits,
        "rediscretisable": bool(core.manifest.get("rediscretisable")),
        "design": repr(float(core.period)),
        "nanoseconds": round(core.period * 1e9),
        "unit": lambda port: f", {_unit(port.unit)}" if _unit(port.unit) else "",
        "sim": _demonstration(core),
        "per_mm": LENGTHS.get(hal_string(core.inputs[0].unit), 1.0),
    }


def _unit(unit: str) -> str:
    """A unit as text, empty for a pure number."""
    return "" if unit == "1" else hal_string(unit)


def _about(doc: str, unit: str, interval: str = "") -> str:
    """What a number is, in one line."""
    return ", ".join(p for p in (hal_string(doc), _unit(unit), interval and f"in {interval}") if p)


def _pins(ports: tuple[Port, ...]) -> list[Pin]:
    names = pins((p.name, p.role) for p in ports)
    return [
        Pin(
            hal,
            hal.replace("-", "_"),
            p.name,
            _unit(p.unit),
            hal_string(p.doc or p.key),
            _about(p.doc or p.key, p.unit),
            p.start,
        )
        for hal, p in zip(names, ports, strict=True)
    ]


def _limits(core: Core) -> list[Setting]:
    """The limits that the machine layer watches: numbers from 0, which means none."""
    unit, way = core.outputs[0].unit, core.inputs[0].unit
    rows = [
        ("maxoutput", "*inst->maxoutput", "max_output", core.limits.max_output, unit, "largest size of an output"),
        ("max-following-error", None, "max_error", core.limits.max_error, way, "fault above this size of error"),
        (
            "max-wrong-way",
            None,
            "max_wrong_way",
            core.limits.max_wrong_way,
            way,
            "fault after this way against the output",
        ),
    ]
    return [
        _setting(core, Knob(hal, hal, "float", value, (), unit, doc, 0.0, math.inf, "[0, inf)"), hal, (place,), source)
        for hal, source, place, value, unit, doc in rows
    ]


def _knob(core: Core, knob: Knob, hal: str) -> Setting:
    return _setting(core, knob, hal, tuple(f"params.{p}" for p in knob.places))


def _setting(core: Core, knob: Knob, hal: str, places: tuple[str, ...], source: str | None = None) -> Setting:
    c = hal.replace("-", "_")
    hal_type = {"float": "float", "int": "s32", "choice": "s32", "bool": "bit"}[knob.kind]
    held = {"float": core.real, "int": "int", "choice": "int", "bool": "int"}[knob.kind]
    read = source or f"inst->{c}"
    start = repr(float(knob.value)) if knob.kind == "float" else str(int(knob.value))
    wanted = f"{read} != 0" if knob.kind == "bool" else f"({held}){read}"
    interval = "" if knob.kind == "bool" else _interval(knob)
    doc, unit = hal_string(knob.doc or knob.key), _unit(knob.unit)
    about = f"{doc}: {interval}" if knob.kind == "choice" else _about(doc, unit, interval)
    outside = _outside(core, knob)
    return Setting(hal, c, hal_type, start, unit, doc, about, interval, held, wanted, outside, places)


def _interval(knob: Knob) -> str:
    if knob.range:
        return hal_string(knob.range)
    left = "(" if math.isinf(knob.low) else "["
    right = ")" if math.isinf(knob.high) else "]"
    return f"{left}{knob.low:g}, {knob.high:g}{right}"


def _outside(core: Core, knob: Knob) -> str:
    """C that is true for a value out of the knob's range, or not finite."""
    if knob.kind == "bool":
        return "0"
    if knob.kind in ("int", "choice"):
        low, high = max(knob.low, S32[0]), min(knob.high, S32[1])
        bounds = [f"wanted < {int(low)}"] if low > S32[0] else []
        bounds += [f"wanted > {int(high)}"] if high < S32[1] else []
        return " || ".join(bounds) or "0"
    largest = "FLT_MAX" if core.real == "float" else "DBL_MAX"
    above = ">" if knob.range.startswith("(") and math.isfinite(knob.low) else ">="
    below = "<" if knob.range.endswith(")") and math.isfinite(knob.high) else "<="
    low_text = number(knob.low, core.real) if math.isfinite(knob.low) else f"-{largest}"
    high_text = number(knob.high, core.real) if math.isfinite(knob.high) else largest
    return f"!(wanted {above} {low_text} && wanted {below} {high_text})"


def _demonstration(core: Core) -> dict[str, Any]:
    """Size and speed of the demonstration's plant, none of any machine: full drive makes 100 or 200 mm/s."""
    unit = LENGTHS.get(hal_string(core.inputs[0].unit), 1.0)
    full = core.full_scale or core.limits.max_output or 1.0
    kind = {"torque": "torque", "force": "torque", "position": "position"}.get(core.drive, "speed")
    at_full = {"speed": 100.0, "torque": 200.0, "position": 1.0}[kind] * unit
    return {
        "kind": kind,
        "gain": 1.0 if kind == "position" else at_full / full,
        "full": full,
        "amplitude": 10.0 * unit,
        "frequency": 0.2,
        "lag": min(1.0, core.period / {"speed": 1.0, "torque": 0.1, "position": 0.02}[kind]),
        "seconds": max(4, math.ceil(200 * core.period)),
    }
