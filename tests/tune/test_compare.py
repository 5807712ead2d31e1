"""Comparison: the same effort, the same unseen plants, paired intervals, and a sentence that claims no more."""

from __future__ import annotations

import numpy as np
import pytest

from leadscrew.experiment import Experiment
from leadscrew.figures.table import NOTHING, number
from leadscrew.report.comparison import metric_table, ranking_table
from leadscrew.tune.checkpoints import Journal
from leadscrew.tune.compare import compare, confidence, contest, judged, worse_than_seen
from leadscrew.tune.executors import crew
from leadscrew.tune.job import Job
from leadscrew.tune.measure import Samples
from leadscrew.tune.objective import constraint, goal
from leadscrew.tune.statistics import Interval, Pair, bad_plants, paired, per_plant, resamples, standing
from leadscrew.util.errors import NameUnknown, ValueRefused

JOB = Job(Experiment("vud_lathe"), ("fig11a_step_m50",), 2.2)
OVER = {"plant.full_duty_speed_mm_s": (259.0, 334.0)}
A, B, C = "corrected.vud_beta_e", "ours.pd", "paper.vud"
VARY = {A: ["controller.output_gain=0.5:4:log", "controller.tau=0.3:1.5"], B: ["controller.kp=0.01:1:log"]}
ASKED = {"vary": VARY, "over": OVER, "plants": 4, "unseen": 30, "budget": 40, "seed": 2}


def done(workers=None, journal=None, names=(A, B, C)):
    return compare(JOB, names, ["settling_2um"], ["overshoot<=0.02"], crew=workers, journal=journal, **ASKED)


@pytest.fixture(scope="module")
def found():
    with crew(threads=1) as one:
        return done(one)


def plain(result):
    said = result.as_dict()
    for r in (said, *(r["tuned"] for r in said["results"] if r["tuned"])):
        del r["wall_s"], r["crew"]
    return said


@pytest.mark.slow
def test_ranks_on_plants_that_no_tuning_saw(found):
    assert [r.name for r in found.results][-1] == C, "it never comes within 2 um"
    assert found.results[-1].bad == 30 and found.results[0].bad <= found.results[1].bad
    seen = {v for r in found.results for v in r.samples.columns["plant.full_duty_speed_mm_s"]}
    assert len(seen) == 30, "all on the same plants"
    for r in found.results[:2]:
        assert r.tuned is not None and r.tuned.budget == 40
        assert not seen & set(r.tuned.samples["tuned"].columns["plant.full_duty_speed_mm_s"])
    assert found.results[-1].tuned is None


@pytest.mark.slow
def test_it_is_the_same_on_two_threads_and_after_an_interruption(found, tmp_path):
    with crew(threads=2) as two:
        asked = contest(JOB, (A, B, C), ["settling_2um"], ["overshoot<=0.02"], **ASKED)
        journal = Journal(tmp_path / "j", asked.question())
        assert str(plain(done(two, journal))) == str(plain(found))
        chunks = sorted((tmp_path / "j").glob("chunk_*"))
        for chunk in chunks[3::2]:
            chunk.unlink()
        assert str(plain(done(two, Journal(tmp_path / "j", asked.question(), resume=True)))) == str(plain(found))


@pytest.mark.slow
def test_the_sentence_says_effort_plants_difference_and_what_is_not_shown(found):
    text = found.sentence()
    pair = found.pairs[0]
    for words in ("30 simulated plants that no tuning saw", "plant.full_duty_speed_mm_s in 259:334", "95 % interval",
                  "40 evaluations at most", "by cma on 4 other plants, seed 2", f"{C} was taken without tuning",
                  "nothing is shown about", f"{number(pair.difference.value)} s"):  # fmt: skip
        assert words in text, words


def test_what_is_not_different_is_not_called_so():
    rng = np.random.default_rng(0)
    a = rng.normal(1.0, 0.1, 50)
    good = np.zeros(50, dtype=bool)
    same = paired("a", "b", a, a + rng.normal(0.0, 0.1, 50), good, good, 0)
    assert same.difference.low < 0 < same.difference.high and not same.shown
    less = paired("a", "b", a, a + 0.01 + rng.normal(0.0, 0.001, 50), good, good, 0)
    assert less.shown and less.difference.high < 0, "pairing finds what is a tenth of the spread"


@pytest.mark.slow
def test_intervals_hold_what_they_promise():
    """Of 95 % intervals of a mean about 95 % hold it: against a known normal distribution."""
    rng = np.random.default_rng(1)
    held = 0
    for k in range(200):
        s = standing(rng.normal(3.0, 1.0, 60), k)
        held += s.mean.low <= 3.0 <= s.mean.high
    assert 0.89 <= held / 200 <= 0.99
    assert worse_than_seen(200) == pytest.approx(1 - 0.05 ** (1 / 200))


def test_a_metric_to_keep_above_a_bound_is_judged_by_its_smallest_values():
    values = np.arange(21.0)
    most, least = standing(values, 0), standing(values, 0, upper=False)
    assert (most.p95.value, most.worst) == (19.0, 20.0) and (least.p95.value, least.worst) == (1.0, 0.0)
    assert most.p95.low > 10.0 and least.p95.high < 10.0
    lost = {"a": np.full(3, np.nan), "b": np.array([np.nan, np.nan, 0.2])}
    runs = Samples({}, {"a": {"m": np.array([1.0, 5.0, 9.0])}, "b": {"m": np.array([3.0, 2.0, 9.0])}}, lost)
    for text, expected in (("m<=9", [3.0, 5.0]), ("m>=0", [1.0, 2.0]), ("mean:m>=0", [2.0, 3.5])):
        found = per_plant(constraint(text), runs)
        assert found[:2].tolist() == expected and np.isnan(found[2]), text
    # a worst case is missed by a plant; a mean over the plants by none alone; a run that diverged always counts
    for text, bad in (
        ("m>=2", [True, False, True]),
        ("m<=3", [False, True, True]),
        ("mean:m>=9", [False, False, True]),
    ):
        assert bad_plants(runs, [goal("m")], [constraint(text)]).tolist() == bad, text


def test_an_order_is_shown_from_95_of_100_resamples_on():
    nothing = Interval(0.0, 0.0, 0.0)
    assert Pair("a", "b", 0.95, nothing, 9).shown and not Pair("a", "b", 0.9499, nothing, 9).shown


def test_failed_plants_rank_before_the_goal():
    a, b = np.full(40, 1.0), np.full(40, 2.0)
    bad, good = np.zeros(40, dtype=bool), np.zeros(40, dtype=bool)
    bad[:20] = True
    assert paired("b", "a", b, a, good, bad, 0).order == 1.0
    lost = np.where(bad, np.nan, a)
    pair = paired("b", "a", b, lost, good, bad, 0)
    assert pair.judged == 20 and pair.difference.value == 1.0
    assert standing(lost, 0).judged == 20 and standing(np.full(3, np.nan), 0).judged == 0
    assert resamples(0, 5).max() == 4


def test_a_controller_that_no_plant_could_judge_has_no_score_and_is_not_ranked_first():
    """Both miss the constraint on every plant, so the goal decides: 5 s against no number at all."""
    asked = contest(JOB, (A, B), ["settling_2um"], ["overshoot<=0.02"], over=OVER, unseen=4)

    def runs(settling):
        values = {"settling_2um": np.array(settling), "overshoot": np.full(4, 0.5)}
        return Samples({}, {"fig11a_step_m50": values}, {"fig11a_step_m50": np.full(4, np.nan)})

    unjudged, slow = (asked.contenders[0], None, runs([np.nan] * 4)), (asked.contenders[1], None, runs([5.0] * 4))
    for order in ([unjudged, slow], [slow, unjudged]):
        ranked = judged(asked, order, "", 0.0)
        assert [r.name for r in ranked.results] == [B, A] and [r.bad for r in ranked.results] == [4, 4]
        none = ranked.results[1].standings["settling_2um"]
        assert none.judged == 0 and np.isnan([*none.mean, *none.p95, none.worst]).all()
        assert ranked.pairs[0].order == 1.0 and ranked.pairs[0].judged == 0
        assert ranking_table(ranked).rows[1][0] == NOTHING, "no rank without a score"
        assert ranking_table(ranked).rows[1][4] == f"{NOTHING} [{NOTHING}, {NOTHING}]"
        assert "could not be compared, because on no plant both could be judged" in ranked.sentence()


def of_runs(settling, overshoot=0.0, over=OVER):
    """A comparison of A and B in which these settling times came out, per plant."""
    asked = contest(JOB, (A, B), ["settling_2um"], ["overshoot<=0.02"], over=over, unseen=len(settling[0]))
    varied = {k: np.linspace(*ends, len(settling[0])) for k, ends in over.items()}

    def runs(seconds):
        values = {"settling_2um": np.array(seconds), "overshoot": np.full(len(seconds), overshoot)}
        lost = {"fig11a_step_m50": np.full(len(seconds), np.nan)}
        return Samples(varied or {"held": np.zeros(len(seconds))}, {"fig11a_step_m50": values}, lost)

    measured = [(c, None, runs(s)) for c, s in zip(asked.contenders, settling, strict=True)]
    return judged(asked, measured, "", 0.0)


def test_one_plant_run_200_times_supports_no_confidence():
    found = of_runs(([1.5] * 200, [1.25] * 200), over={})
    assert found.same_run and [r.name for r in found.results] == [B, A]
    said = found.as_dict()
    texts = [found.sentence(), confidence(found), *map(str, (*ranking_table(found).rows, *metric_table(found).rows))]
    assert not [t for t in texts if "95 %" in t or "resamples" in t or "[1." in t]
    assert f"the settling_2um of {B} was smaller than that of {A} by 0.25 s" in found.sentence()
    assert found.sentence().startswith("On the machine as it is, in one run without spread, ")
    assert ranking_table(found).rows[0][4:] == ["1.25", "no spread"]
    assert found.notes[0].startswith("all 200 runs of each controller are the same run, bit for bit: nothing varies")
    assert not said["pairs"][0]["shown"] and np.isnan(said["pairs"][0]["order"])
    for pair in found.pairs:
        assert np.isnan([pair.difference.low, pair.difference.high]).all() and pair.difference.value == -0.25


def test_noise_alone_gives_runs_of_one_machine_and_not_plants():
    found = of_runs((np.linspace(1.4, 1.6, 200), np.linspace(1.2, 1.3, 200)), over={})
    assert not found.same_run and found.notes == []
    assert found.sentence().startswith("In 200 runs of the machine as it is, which differ in noise alone")
    assert "paired over the 200 runs" in found.sentence()
    # (1 - x)^200 = 0.05 for x = 1.49 %
    assert "at most 1.5 % of all runs of this machine" in confidence(found)
    assert "of all plants" in confidence(of_runs(([1.5] * 9, [1.25] * 9)))


def test_one_judged_plant_has_no_interval():
    found = of_runs(([np.nan, 1.5, np.nan], [1.2, 1.25, np.nan]))
    one = next(r for r in found.results if r.name == A).standings["settling_2um"]
    assert one.judged == 1 and one.mean.value == 1.5 and np.isnan([one.mean.low, one.p95.high]).all()
    assert "by 0.25 s on the one plant on which both could be judged, which shows no spread" in found.sentence()


@pytest.mark.parametrize(
    ("names", "change", "error", "words"),
    [
        ((A,), {}, ValueRefused, "two controllers or more"),
        ((A, A), {}, ValueRefused, f"{A}: given twice"),
        ((A, "nothing"), {}, NameUnknown, "no controller 'nothing'"),
        ((A, B), {"vary": {"x": ["k=0:1"]}}, NameUnknown, "--vary: no contender is called 'x'"),
        ((A, B), {"vary": {B: ["controller.kq=0:1"]}}, NameUnknown, f"{B}: --vary: there is no parameter"),
        ((A, B), {"goals": []}, ValueRefused, "--minimise is missing"),
        ((A, B), {"goals": ["speed"]}, NameUnknown, "there is no metric 'speed'"),
        ((A, B), {"unseen": 1}, ValueRefused, "unseen"),
        ((A, B), {"constraints": ["overshoot<=1", "overshoot>=2"]}, ValueRefused, "contradict"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_in_one_sentence(names, change, error, words):
    asked = {"goals": ["overshoot"], "constraints": [], "over": OVER, **change}
    with pytest.raises(error) as caught:
        contest(JOB, names, asked.pop("goals"), asked.pop("constraints"), **asked)
    assert words in str(caught.value)
