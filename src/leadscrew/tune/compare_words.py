"""What may be said of a comparison, and its tables."""

from __future__ import annotations

import math

from leadscrew.report.tables import NOTHING, number
from leadscrew.tune.compare_result import Comparison, Result
from leadscrew.tune.compare_statistics import Interval, Pair


def sentence(found: Comparison) -> str:
    """What a referee would accept: effort, plants, paired difference with its interval, and what is not shown."""
    best, second = found.results[0], found.results[1]
    pair = found.pairs[0]
    over = ", ".join(f"{k} in {v}" for k, v in found.over.items())
    where = f" in {len(found.scenarios)} scenarios" if len(found.scenarios) > 1 else ""
    runs = (
        "On the machine as it is, in one run without spread"
        if found.same_run
        else f"On {found.unseen} simulated plants that no tuning saw ({over})"
        if over
        else f"In {found.unseen} runs of the machine as it is, which differ in noise alone and which no tuning saw"
    )
    kept = (
        _kept_alone(found, best, second)
        if found.same_run
        else f"{best.name} kept all constraints on {found.unseen - best.bad} of them and {second.name} on "
        f"{found.unseen - second.bad}; "
        if found.constraints
        else f"{best.name} failed on {best.bad} of them and {second.name} on {second.bad}; "
        if best.bad or second.bad
        else ""
    )
    return (
        f"{runs}{where}, {kept}{_difference(found, pair)}; "
        f"{_efforts(found)}; nothing is shown about plants or scenarios outside of these, about the real machine, "
        f"{'or about other seeds or longer tuning' if found.optimiser else 'or about other settings of them'}."
    )


def _kept_alone(found: Comparison, best: Result, second: Result) -> str:
    """What each did in the only run there is."""
    kept, lost = ("kept all constraints", "missed a constraint or failed") if found.constraints else ("ran", "failed")
    if not found.constraints and not (best.bad or second.bad):
        return ""
    return f"{best.name} {lost if best.bad else kept} and {second.name} {lost if second.bad else kept}; "


def nothing_varied(found: Comparison) -> list[str]:
    """Says that all runs of a contender are the same run; nothing where they are not."""
    if not found.same_run:
        return []
    return [
        f"all {found.unseen} runs of each controller are the same run, bit for bit: nothing varies from plant to plant "
        "and no noise reaches a metric, so there is no confidence to state; name what varies with --over"
    ]


def confidence(found: Comparison) -> str:
    """What the worst run seen says of those not seen; empty where nothing varied."""
    if found.same_run:
        return ""
    most = 100.0 * worse_than_seen(found.unseen)
    others = "all plants" if found.over else "all runs of this machine"
    return f"With 95 % confidence at most {most:.2g} % of {others} are worse than the worst one seen"


def _difference(found: Comparison, pair: Pair) -> str:
    goal = found.goals[0]
    what = f"{goal.metric}{f' in {goal.scenario}' if goal.scenario else ''}"
    d, unit = pair.difference, f" {found.unit}" if found.unit else ""
    if not pair.judged:
        return f"{what} could not be compared, because on no plant both could be judged"
    if found.same_run or math.isnan(d.low):
        relation = "equal to" if d.value == 0.0 else "smaller than" if d.value < 0.0 else "larger than"
        on = "" if found.same_run else " on the one plant on which both could be judged, which shows no spread"
        by = f" by {number(abs(d.value))}{unit}" if d.value else ""
        return f"the {what} of {pair.better} was {relation} that of {pair.worse}{by}{on}"
    numbers = f"{number(d.value)}{unit} (95 % interval {number(d.low)} to {number(d.high)})"
    of = "plants" if found.over else "runs"
    paired = f"paired over the {pair.judged} {of} on which both could be judged, {numbers}"
    if d.low <= 0.0 <= d.high:
        return f"no difference in the mean {what} is shown between {pair.better} and {pair.worse}: {paired}"
    relation = "smaller" if d.value < 0.0 else "larger"
    return f"the mean {what} of {pair.better} was {relation} than that of {pair.worse}: {paired}"


def _efforts(found: Comparison) -> str:
    tuned = [r for r in found.results if r.tuned]
    plain = [r.name for r in found.results if not r.tuned]
    parts = []
    if tuned:
        who = "each contender was" if not plain else " and ".join(r.name for r in tuned)
        who += "" if not plain else " were each" if len(tuned) > 1 else " was"
        used = ", ".join(str(r.tuned.used) for r in tuned if r.tuned)
        plants = f"{found.plants} other plant{'s' if found.plants > 1 else ''}"
        parts.append(
            f"{who} tuned once with {found.budget} evaluations at most ({used} used) by {found.optimiser} on "
            f"{plants}, seed {found.seed}"
        )
    if plain:
        parts.append(f"{' and '.join(plain)} {'were' if len(plain) > 1 else 'was'} taken without tuning")
    return ", ".join(parts)


def spread(interval: Interval) -> str:
    """A number with its interval."""
    if math.isnan(interval.low) and not math.isnan(interval.value):
        return number(interval.value)
    return f"{number(interval.value)} [{number(interval.low)}, {number(interval.high)}]"


RANKING = ("rank", "controller", "effort", "plants kept", "first goal, mean [95 %]", "before the next one in")


def ranking_rows(found: Comparison) -> list[list[str]]:
    """The ranking."""
    rows = []
    goal = found.goals[0]
    key = f"{goal.metric}{f'@{goal.scenario}' if goal.scenario else ''}"
    for i, r in enumerate(found.results):
        effort = f"{r.tuned.used} evaluations" if r.tuned else "as it is"
        order = ""
        if i < len(found.pairs):
            pair = found.pairs[i]
            shown = "" if pair.shown else " (not shown)"
            order = "no spread" if math.isnan(pair.order) else f"{100 * pair.order:.3g} % of resamples{shown}"
        rank = str(i + 1) if r.standings[key].judged else NOTHING
        rows.append([rank, r.name, effort, f"{found.unseen - r.bad} of {found.unseen}",
                     spread(r.standings[key].mean), order])  # fmt: skip
    return rows


METRICS = ("metric", "unit", "controller", "mean [95 %]", "95th percentile [95 %]", "worst seen", "judged")


def metric_rows(found: Comparison) -> list[list[str]]:
    """Every metric of every contender."""
    return [
        [
            key,
            found.units.get(key, ""),
            r.name,
            spread(s.mean),
            spread(s.p95),
            number(s.worst),
            f"{s.judged} of {found.unseen}",
        ]
        for key in found.results[0].standings
        for r, s in ((r, r.standings[key]) for r in found.results)
    ]


def worse_than_seen(unseen: int) -> float:
    """The part of all plants that may be worse than the worst seen, with 95 % confidence at most."""
    return float(1.0 - 0.05 ** (1.0 / unseen))


def setting(result: Result) -> str:
    """What a contender was run with."""
    if result.tuned is None:
        return ""
    return ", ".join(f"{k} = {number(v)}" for k, v in result.tuned.values.items())
