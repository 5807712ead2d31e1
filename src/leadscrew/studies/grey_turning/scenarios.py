"""What the lathe is asked to do, on which lathe, and the loop of both: hold 150 N at 1,200 1/min in cuts of all kinds.

The paper names neither servo nor sampling time. Plant F's servo (40 rad/s, no dead time) was fitted to Figures 9 and
10 with S9; plant N is slower (20 rad/s, one sample of dead time). Both are sampled every 20 ms and stepped every
millisecond. Runs are judged by the filtered force, as the paper does, and by the true one, which is larger: with the
factors of Figure 9 the filter hides half of the overshoot.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

from leadscrew.disturbances._pulse_load import pulse_load
from leadscrew.kernel.block import Block, metric
from leadscrew.kernel.metrics import (
    NAN,
    OvershootState,
    RiseParams,
    RiseState,
    Window,
    chatter,
    iae,
    max_error,
    overshoot,
    rise,
    rise_time,
    steady_state_error,
)
from leadscrew.kernel.parameters import Doc, Ge, Le, Lt, Unit
from leadscrew.plants._turning import turning
from leadscrew.plants._turning.chip import IRON
from leadscrew.references._cutting_program import DepthProgram, cutting_force, cutting_program
from leadscrew.sensors._load_cell import lathe_reading, load_cell
from leadscrew.study_data import Scenario

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

FORCE_N, RPM = 150.0, 1200.0
"""What is held, sections 5.1 and 5.2."""
PERIOD_S = 0.02
"""Sampling period: 20 ms keep the runout of 20 Hz below half the sampling frequency."""
SUBSTEPS = 20
"""Steps of the plant a period: 1 ms."""


# ---- what is asked
Noise = Annotated[float, Unit("N"), Ge(0), Le(1000), Doc("standard deviation of one reading of the load cell")]
Filter = Annotated[float, Ge(0), Lt(1), Doc("coefficient of the digital filter, alpha; 0: the raw force is fed back")]


class Turn(NamedTuple):
    """A cut at constant force."""

    force: Annotated[float, Unit("N"), Ge(0), Le(5000), Doc("main cutting force to hold")] = FORCE_N
    spindle_rpm: Annotated[float, Unit("1/min"), Ge(1), Le(20000), Doc("spindle speed")] = RPM
    depth: DepthProgram = DepthProgram()
    runout: Annotated[float, Unit("mm"), Ge(0), Le(1), Doc("amplitude of the depth's change over a revolution")] = 0.01
    noise_n: Noise = 2.0
    keep: Filter = 0.8
    hard_spot: Annotated[float, Ge(0), Le(10), Doc("relative rise of the specific force in a hard spot")] = 0.0
    hard_from_s: Annotated[float, Unit("s"), Ge(0), Doc("when it comes")] = 1.5
    hard_for_s: Annotated[float, Unit("s"), Ge(0), Doc("how long it lasts")] = 0.2


FALLING = DepthProgram(1.0, -0.2, 2.0, 3)
"""1 mm, and 0.2 mm less every 2 s, down to 0.4 mm: below it 150 N need more than 150 mm/min."""
RISING = DepthProgram(0.4, 0.2, 2.0, 3)

SCENARIOS: dict[str, Scenario] = {
    s.name: s
    for s in (
        Scenario("fig6_fixed_depth", Turn(), "150 N at 1 mm and 1,200 1/min, tool in the cut, feed from rest", 3.0),
        Scenario("fig9_falling_depth", Turn(depth=FALLING), "the same; the depth falls by 0.2 mm every 2 s", 8.0),
        Scenario("rising_depth", Turn(depth=RISING), "the depth rises from 0.4 mm by 0.2 mm every 2 s", 8.0),
        Scenario("fixed_depth_on_plant_n", Turn(), "fixed depth with a slower servo that has dead time", 3.0),
        Scenario("fixed_depth_on_plant_f_iron", Turn(), "fixed depth in iron", 3.0),
        Scenario("noise_free", Turn(runout=0.0, noise_n=0.0), "fixed depth without noise and runout", 3.0),
        Scenario("noise_free_falling", Turn(depth=FALLING, runout=0.0, noise_n=0.0), "falling depth without them", 8.0),
        Scenario("raw_force", Turn(keep=0.0), "fixed depth, the force fed back without the digital filter", 3.0),
        Scenario("fig5_feedback", Turn(noise_n=8.0), "fixed depth for 6 s with the scatter of Figure 5", 6.0),
        Scenario("tool_entry", Turn(depth=DepthProgram(entry_s=0.4)), "the edge enters within 0.4 s, then 1 mm", 4.0),
        Scenario("hard_spot", Turn(hard_spot=1.0), "a spot of 0.2 s that doubles the force", 4.0),
    )
}


# ---- on which lathe
class Machine(NamedTuple):
    """A lathe in the cut."""

    doc: str
    plant: Block


SLOW = {"servo.rate": 20.0, "servo.dead_time_s": 0.02}
IRON_LAW = {f"law.{key}": value for key, value in IRON._asdict().items()}
FOLLOWING = {"radial.gain": 8.57}
"""A radial axis that takes 0.25 s from 10 to 90 % of a step, as the depth loop of the whole lathe does."""

MACHINES: dict[str, Machine] = {
    "plant_f": Machine("S45C, feed servo of 40 rad/s", turning),
    "plant_n": Machine("S45C, feed servo of 20 rad/s with 20 ms of dead time", turning.using(**SLOW)),
    "plant_f_iron": Machine("iron, feed servo of 40 rad/s", turning.using(**IRON_LAW)),
    "plant_f_radial": Machine("plant F; the depth follows its programme in 0.25 s", turning.using(**FOLLOWING)),
    "plant_n_radial": Machine("plant N; the depth follows its programme in 0.25 s", turning.using(**SLOW, **FOLLOWING)),
}


def machine_of(scenario: Scenario) -> str:
    """The machine that a scenario runs on: the one it ends in (``..._on_NAME``), else plant F.

    Where the depth changes it is plant F whose radial axis moves it.
    """
    named = next((name for name in MACHINES if scenario.name.endswith(f"_on_{name}")), None)
    return named or ("plant_f_radial" if scenario.params.depth.steps else "plant_f")


# ---- by what it is judged
def percent_of_command(p, s):
    """The largest excess, percent of the command."""
    return 100.0 * s.excess / s.last_command if s.last_command > 0.0 else NAN


@metric(Window(), OvershootState(), output=percent_of_command, unit="%")
def filtered_overshoot(p, s, command, feedback, t, dt):
    """Largest excess of the filtered force beyond the set-point, percent of it."""
    return overshoot(p, s, command, feedback, t, dt)


@metric(RiseParams(), RiseState(), output=rise, unit="s")
def filtered_rise(p, s, command, feedback, t, dt):
    """Time that the filtered force takes from 10 to 90 % of the set-point."""
    return rise_time(p, s, command, feedback, t, dt)


class SteadyState(NamedTuple):
    """Sums over the window."""

    total: float = 0.0
    samples: float = 0.0


def mean_share(p, s):
    """The mean, percent."""
    return 100.0 * s.total / s.samples if s.samples > 0.0 else NAN


@metric(Window(), SteadyState(), output=mean_share, unit="%")
def filtered_steady(p, s, command, feedback, t, dt):
    """Mean size of the set-point less the filtered force from ``from_time`` on, percent of the set-point."""
    late = 1.0 if t > p.from_time - 0.5 * dt else 0.0
    return SteadyState(s.total + late * abs(command - feedback) / max(command, 1e-9), s.samples + late)


class CostParams(NamedTuple):
    """What a percent too much is worth."""

    free: Annotated[float, Ge(0), Doc("overshoot of the true force that costs nothing, % of the set-point")] = 10.0
    penalty: Annotated[float, Unit("N s"), Ge(0), Doc("for each percent above it")] = 1.0


class CostState(NamedTuple):
    """So far."""

    area: float = 0.0
    over: Annotated[float, Doc("largest excess of the true force, % of the set-point")] = 0.0


def priced(p, s):
    """Area and penalty."""
    return s.area + p.penalty * max(s.over - p.free, 0.0)


@metric(CostParams(), CostState(), output=priced, unit="N s")
def cut_cost(p, s, command, actual, dt):
    """Integral of the true force's error, and a penalty for what it exceeds the set-point by."""
    off = actual - command
    return CostState(s.area + abs(off) * dt, max(s.over, 100.0 * off / max(command, 1e-9)))


def metrics_of(scenario: Scenario) -> dict[str, Block]:
    """The filtered force's as in the paper, the true one's in N; steady: the last second."""
    late = scenario.duration_s - 1.0
    return {
        "filtered_overshoot": filtered_overshoot,
        "filtered_rise": filtered_rise,
        "filtered_steady": filtered_steady(from_time=late),
        "overshoot": overshoot,
        "rise_time": rise_time,
        "steady_state_error": steady_state_error(from_time=late),
        "max_error": max_error(from_time=1.0),
        "iae": iae,
        "cut_cost": cut_cost,
        "chatter": chatter,
    }


# ---- the loop
def takes_cut(controller: Block) -> bool:
    """Whether a controller reads the programme and all sensors; any other gets the force, commanded and filtered."""
    return bool(getattr(controller.step, "takes_cut", False))


def build(controller: Block, scenario: Scenario, machine: str | None = None, **options: Any) -> Loop:
    """The loop of a controller in a scenario, on the scenario's machine unless another is named.

    A controller that takes the depth ahead knows how the machine's radial axis moves. ``options``: of the loop
    (``substeps``, ``metrics``, ``seed``, ``period``, ``sensor``, ``disturbance``).
    """
    from leadscrew.kernel.loop import Loop

    turn: Turn = scenario.params
    whole = takes_cut(controller)
    depth = {f"depth.{key}": value for key, value in turn.depth._asdict().items()}
    plant = MACHINES[machine or machine_of(scenario)].plant(**depth, spindle_rpm=turn.spindle_rpm, runout=turn.runout)
    if plant.params.radial.gain > 0.0 and hasattr(controller.params, "radial"):
        controller = controller(**FOLLOWING)
    sensor = lathe_reading if whole else load_cell
    given: dict[str, Any] = {
        "reference": cutting_program(force=turn.force, **depth) if whole else cutting_force(force=turn.force),
        "controller": controller,
        "plant": plant,
        "sensor": sensor(noise_n=turn.noise_n, keep=turn.keep),
        "disturbance": pulse_load(size=turn.hard_spot, start=turn.hard_from_s, duration=turn.hard_for_s),
        "period": PERIOD_S,
        "substeps": SUBSTEPS,
        "metrics": metrics_of(scenario),
        "name": f"{controller.name} in {scenario.name}",
    }
    return Loop(**(given | options))
