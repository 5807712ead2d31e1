"""What the design of a nonlinear PID says, step by step."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from leadscrew.design.npid import Candidate, NpidDesign

WHERE = {
    "stability at rest": "the gain stands at its limit of stability at rest",
    "stability under command and load": "the slope stands at its limit of stability under command and load",
    "noise budget": "the noise of the drive at rest stands at its budget",
}


def report(design: NpidDesign) -> str:
    """All steps as text."""
    steps = (
        ("axis", axis_lines(design)),
        ("PID", pid_lines(design)),
        ("limits", limit_lines(design)),
        ("search", search_lines(design)),
        ("result", result_lines(design)),
    )
    return "\n\n".join(
        "\n".join([f"{n}. {name}", *(f"   {x}".rstrip() for x in lines)])
        for n, (name, lines) in enumerate(steps, start=1)
    )


def axis_lines(d: NpidDesign) -> list[str]:
    """The axis and its work."""
    a, w = d.axis, d.work
    cases = ", ".join(c.name for c in w.cases)
    return [
        f"{a.gain:g} / (s^2 + {a.damping:g} s + {a.stiffness:g}) mm/V, dead time {1e3 * a.dead_time_s:g} ms, "
        f"sampled at {1.0 / a.period_s:g} Hz",
        f"{w.amplitude_mm:g} mm at {w.frequency_hz:g} Hz; force lines at {', '.join(f'{f:g}' for f in w.lines_hz)} Hz; "
        f"cases: {cases}",
        f"encoder {w.encoder_um:g} um, noise {w.noise_um:g} um",
    ]


def pid_lines(d: NpidDesign) -> list[str]:
    """The linear loop."""
    g = d.gains
    said = [f"kp {g.kp:.6g} V/mm, ki {g.ki:.6g} V/(mm s), kd {g.kd:.6g} V s/mm"]
    if d.retuned is not None:
        said.append(
            f"retuned for Ms {d.retuned.asked:g}: the response to force at the lines is {d.retuned.ratio:.3f} of what "
            f"it was, Ms {d.retuned.ms:.4g}"
        )
    b = d.base
    return [*said, f"error {b.rms_um:.3g} um rms, drive at rest {b.rest_du_mv:.3g} mV from period to period"]


def limit_lines(d: NpidDesign) -> list[str]:
    """What bounds the nonlinear gain."""
    m = d.limits
    return [
        f"at rest: gain up to {m.rest:.4g} ({m.rest_by}, a verified matrix inequality), / m1 = {m.m1:g}: {m.gain:.4g}",
        f"driven: slope up to {m.driven:.4g} (incremental circle, a verified matrix inequality), / m2 = {m.m2:g}: "
        f"{m.slope:.4g}",
        f"noise: at most {m.budget_mv:.3g} mV from period to period at rest",
        f"for comparison, the Nyquist limit of a constant gain: {m.nyquist:.4g}",
    ]


def search_lines(d: NpidDesign) -> list[str]:
    """What was tried, and the degenerate optimum."""
    return [
        f"{len(d.grid)} candidates of the law {d.law}, then two finer grids; score: mean of all amplitudes against the "
        "PID's",
        f"without the noise budget the best of them is {named(d, d.free)}: score {d.free.score:.3f} at "
        f"{d.free.rest_du_mv:.3g} mV",
        f"a linear PID within the same limits: gains x {d.linear.strength:.3f}, score {d.linear.score:.3f} at "
        f"{d.linear.rest_du_mv:.3g} mV",
    ]


def result_lines(d: NpidDesign) -> list[str]:
    """The controller, and what binds."""
    b = d.best
    binding = "; ".join(WHERE[name] for name in d.binding) or "nothing: the optimum lies inside all limits"
    return [
        f"{d.block_name} with {named(d, b)}: gain up to {b.gain:.4g}, slope up to {b.slope:.4g}",
        f"score {b.score:.3f}: {100.0 * (1.0 - b.score):.1f} % less than the PID, "
        f"{100.0 * (1.0 - b.score / d.linear.score):.1f} % less than the linear PID within the same limits",
        f"error {b.rms_um:.3g} um rms, {b.largest_um:.3g} um at most; drive at rest {b.rest_du_mv:.3g} mV, at work "
        f"{b.work_du_mv:.3g} mV",
        f"what binds: {binding}",
        f"{d.driven.grade}: {d.driven.statement}",
    ]


def named(d: NpidDesign, c: Candidate) -> str:
    """A candidate by its parameters."""
    if d.law == "slope":
        return f"k = {c.strength:.4g}, es = {c.scale_um:.3g} um"
    return f"alpha = {c.strength / c.scale_um:.4g} 1/um, e_max = {c.scale_um:.3g} um"
