"""Rows of grey predictors: what a step costs in a compiled loop, beside the same loop that predicts nothing."""

from __future__ import annotations

from typing import Any, NamedTuple

from leadscrew.bench import measuring, probes
from leadscrew.bench.measuring import interleaved, load, row
from leadscrew.grey.gm11 import ahead, fit
from leadscrew.grey.predictors import KINDS, predicted
from leadscrew.grey.window import Window, pushed
from leadscrew.kernel.block import controller

POINTS = 20_000
BOUND_NS = 60.0
SHOWN = ("gm11", "gm11_clamped", "gm11_shifted", "dgm11", "gm11_exponential", "verhulst", "gm11_residual", "line")


class Asked(NamedTuple):
    """Which predictor."""

    kind: int = 1


class Kept(NamedTuple):
    """The window of the loop."""

    window: Window = Window()


@controller(Asked(), Kept())
def predicts(p, s, command):
    """A predictor chosen by a number, of a force about 150 N."""
    window = pushed(s.window, 150.0 + command.x)
    return Kept(window), predicted(p.kind, window, 1.0, 150.0, 150.0)


class Chained(NamedTuple):
    """The window of the loop and the last prediction."""

    window: Window = Window()
    value: float = 0.0


@controller(Asked(), Chained())
def waits(p, s, command):
    """GM(1,1), each of whose samples waits for the prediction before."""
    window = pushed(s.window, 150.0 + command.x + 1e-6 * s.value)
    value = ahead(window, fit(window), 1.0)
    return Chained(window, value), value


def nanoseconds(rounds: int, kinds: tuple[str, ...] = SHOWN) -> dict[str, float]:
    """Marginal cost of a prediction in a compiled loop, ns: a loop with it less the loop that gives the last value."""
    calls = {k: measuring.single(probes.probe(predicts(kind=KINDS[k])), POINTS) for k in ("last", *kinds)}
    calls["chain"] = measuring.single(probes.probe(waits), POINTS)
    seen = {k: v / POINTS * 1e9 for k, v in interleaved(calls, rounds).items()}
    return {k: v - seen["last"] for k, v in seen.items() if k != "last"}


def rows(rounds: int) -> list[dict[str, Any]]:
    """All rows of this file; GM(1,1) has the target."""
    busy = load()
    ns = nanoseconds(rounds)
    remark = "" if busy is None else f"load average {busy:.2f}"
    what = dict.fromkeys(SHOWN, "marginal cost in the loop")
    what["chain"] = "gm11, each sample waits for the last prediction"
    return [
        row("grey prediction", f"{k}, {what[k]}" if k != "chain" else what[k], ns[k], "ns",
            at_most=BOUND_NS if k in ("gm11", "chain") else None, remark=remark)
        for k in (*SHOWN, "chain")
    ]  # fmt: skip
