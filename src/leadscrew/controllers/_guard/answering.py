"""Does the force answer the feed? A load cell that stands still under its own noise does not.

A force loop raises its output for two reasons: the cut has become lighter, then the force fell before and comes back
because of the rise; or the cell does not show the cut, then it shows the same whatever the output does. Each look
follows the mean force ``F`` and the mean output ``U`` (first order, :data:`MEAN_S`)::

    answer        F > min F + answer max(max F, command) since the last one, or F < air_n: no cut. Then U0 = U
    alive         F >= command: the error has changed its sign. Then, and with an answer, U1 = U
    waiting       u > U1 (1 + rise) or u > U0 (1 + rise_most), and F does not fall; U0 and U1 are never above U
    unanswered    it has been waiting for answer_s; the output does not rise from a fifth of that on
    below zero    F < -below_n: no cut pulls

``rise`` finds a cell that stands below the set-point; near it, where noise alone changes the sign of the error, the
output creeps up slowly, and ``rise_most`` ends that. Where ``F`` is below half its command, ``rise`` is larger in the
same ratio, because a small force gives a small answer.

Both stay a cause after the hold until they are disproved, which the hold itself can do: with the feed at 0 a cell that
sees the cut falls, here below half of what it was. A cell that stands still is held for good, a sound one that was
doubted restarts. A cut that becomes so much lighter by and by, a taper say, that the output rises by ``rise_most``
while the force stays within ``answer`` of one value looks like a cell that stands still, and is held for that test.

Source: ours.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.kernel.parameters import Doc, Unit

MEAN_S = 0.1
"""Time constant of both means."""

FALL = 0.5
"""Share of the doubted force below which a held cell is believed again."""

HALF = 0.5
"""Share of the command below which a force is small."""

PATIENCE = 0.2
"""Share of ``answer_s`` after which the output waits for the answer."""


class Answer(NamedTuple):
    """Force and output now and since the references."""

    force: Annotated[float, Unit("N"), Doc("mean raw force")] = 0.0
    output: Annotated[float, Doc("mean output")] = 0.0
    low: Annotated[float, Unit("N"), Doc("smallest mean force since its last answer")] = 0.0
    high: Annotated[float, Unit("N"), Doc("largest mean force since then")] = 0.0
    output_at: Annotated[float, Doc("mean output then")] = 0.0
    output_since: Annotated[float, Doc("mean output when the force was last at its command or above")] = 0.0
    waits_s: Annotated[float, Unit("s"), Doc("how long the output has been up without an answer")] = 0.0
    doubted: Annotated[int, Doc("1 while the feed is held because the force does not answer")] = 0


def answered(checks, air_n, s, command, raw, output, running, dt):
    """The next :class:`Answer`: for finite forces, the output of the last look, and whether the guard runs."""
    part = min(dt / MEAN_S, 1.0)
    force = s.force + part * (raw - s.force)
    mean = s.output + part * (output - s.output)
    low, high = min(s.low, force), max(s.high, force)
    room = checks.answer * max(high, command)
    fell = force < high - room
    rose = force > low + room
    anew = not running or force < air_n or rose or mean < s.output_at
    turned = anew or force >= command or mean < s.output_since
    far = output > s.output_at * (1.0 + checks.rise_most)
    rise = checks.rise * max(1.0, HALF * command / max(high, 1e-9))
    risen = far or (not turned and output > s.output_since * (1.0 + rise))
    waits = s.waits_s + dt if checks.rise > 0.0 and not anew and not fell and risen else 0.0
    late = waits >= checks.answer_s
    kept = late or (s.doubted > 0 and force > FALL * s.high)
    moved = anew and not kept
    tracked = (anew or fell) and not kept
    return Answer(
        force, mean, force if tracked else low, force if tracked else high, mean if moved else s.output_at,
        mean if turned and not kept else s.output_since, waits, 1 if kept else 0,
    )  # fmt: skip


def awaited(checks, answer):
    """Whether the output is to rise no further until the force answers."""
    return answer.waits_s >= PATIENCE * checks.answer_s
