"""``leadscrew identify cutting-force``: what it prints and writes, and what it refuses."""

import json
import tomllib

import numpy as np
import pytest

from leadscrew.identify.cutting_force import fit_forces
from leadscrew.identify.cutting_force_table import read_force_table
from tests.cli.conftest import strict_json
from tests.docs.snippets import ROOT

PUBLISHED = ROOT / "examples" / "turning_forces.csv"
NAME = ("identify", "cutting-force")


@pytest.fixture
def cuts(tmp_path):
    """Writes a table from its lines below ``feed,depth,force``."""

    def write(*lines, header="feed,depth,force"):
        path = tmp_path / "cuts.csv"
        path.write_text("\n".join([header, *lines]) + "\n", encoding="utf-8")
        return path

    return write


def test_the_tables_show_what_the_library_finds(call, cuts):
    fit = fit_forces(read_force_table(PUBLISHED))
    said = call(*NAME, PUBLISHED, "--beside", "1609.5,0.136", "--at", "0.03,1", "--bootstrap", 200)
    lines = said.stdout.splitlines()
    kf = next(x.split() for x in lines if x.startswith("Kf"))
    assert kf[1:4] == [f"{x:,.0f}" for x in fit.chosen.parameters["kf"].interval]
    given = next(x for x in lines if x.startswith("given: kc11"))
    assert "7.1" in given and "0.633" in given
    assert any(x.strip().startswith("0.03") and x.endswith("outside the table") for x in lines)
    assert sum("the same, bootstrap" in x for x in lines) == 2
    assert f"--set plant.law.kf={fit.law.kf:.6g} --set plant.law.exponent={fit.law.exponent:.6g}" in said.stdout
    assert "row 12 repeats row 6" in said.stderr and "not in proportion to the depth" in said.stderr


@pytest.mark.slow
def test_json_and_folder_hold_the_same_result(call, tmp_path):
    out = tmp_path / "cut"
    said = strict_json(call(*NAME, PUBLISHED, "--json", "-o", out, "--at", "0.2,1").stdout)
    assert said["schema_version"] == 1 and said["cuts"] == 7 and said["repeated_rows"] == [[12, 6]]
    assert said["at"][0]["inside"] is True and said["depth_exponent"]["p_value"] < 0.01
    kept = json.loads((out / "cutting_force.json").read_text(encoding="utf-8"))
    assert kept["fits"] == said["fits"] and kept["law"] == said["law"]
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "F = Kf a f^P" in page and "<svg" not in page and "data:image/svg+xml" in page
    assert (out / "cutting_force.png").read_bytes().startswith(b"\x89PNG")
    assert "exists already" in call(*NAME, PUBLISHED, "-o", out, code=2).output


def test_kienzles_notation_at_another_angle_is_the_fit_in_its_own_variables(call):
    """kc11 with its interval is that of a straight line of ln(F / b) against ln(h)."""
    from scipy.stats import linregress, t

    table, sine = read_force_table(PUBLISHED), np.sin(np.radians(60.0))
    line = linregress(np.log(table.feed * sine), np.log(table.force / (table.depth / sine)))
    found = strict_json(call(*NAME, PUBLISHED, "--kappa", 60, "--json").stdout)["kienzle"]
    reach = t.ppf(0.975, 5) * line.intercept_stderr
    assert [found[k] for k in ("kc11", "kc11_low", "kc11_high")] == pytest.approx(
        np.exp(line.intercept + np.array([0.0, -reach, reach]))
    )
    assert found["mc"] == pytest.approx(1.0 - line.slope)


@pytest.mark.slow
def test_simulate_takes_the_file_of_the_folder(call, tmp_path):
    from leadscrew import experiment

    out = tmp_path / "cut"
    call(*NAME, PUBLISHED, "-o", out)
    asked = tomllib.loads((out / "cut.toml").read_text(encoding="utf-8"))
    law = asked["set"]["plant"]["law"]
    assert law == pytest.approx({"kf": 1520.21, "exponent": 0.831887}, rel=1e-5)
    run = experiment.read(out / "cut.toml").loop().run(1.5, record=("plant.force", "plant.feed"))
    # in the steady state feed and force of the simulation are a point of the fitted law
    feed, force = run["plant.feed"][-20:].mean(), run["plant.force"][-20:].mean()
    assert force == pytest.approx(law["kf"] * (feed / 1200.0) ** law["exponent"], rel=0.01)


def test_other_components_become_ratios_and_a_parameter_of_the_plant(call, cuts):
    path = cuts("0.1,1,200,80,50", "0.2,1,350,150,80", "0.4,1,600,270,120", header="f,ap,Fc,Ff,Fp")
    said = strict_json(call(*NAME, path, "--json").stdout)
    assert said["ratios"]["feed_force"]["median"] == pytest.approx(150 / 350)
    assert said["set"][-1] == "plant.feed_force_ratio=0.4286"
    assert "passive force over main force: 0.229" in call(*NAME, path).stdout


@pytest.mark.slow
def test_an_exponent_that_no_plant_takes_makes_no_simulation(call, cuts, tmp_path):
    path = cuts("0.1,1,200", "0.2,1,430", "0.4,1,900", "0.4,2,1800")
    done = call(*NAME, path, "-o", tmp_path / "out")
    assert "not for a simulation: an exponent of 1.0" in done.stdout and "plant.law" not in done.stdout
    assert "reaches outside 0 to 1" in done.stderr
    assert "cut.toml" not in {p.name for p in (tmp_path / "out").iterdir()}


@pytest.mark.slow
def test_a_long_table_with_many_depths_makes_a_report(call, cuts, tmp_path):
    rng = np.random.default_rng(9)
    rows = [f"{f:.4f},{a:.4f},{1800 * a * f**0.75:.3f}" for f, a in rng.uniform(0.1, 0.9, (2000, 2))]
    done = call(*NAME, cuts(*rows), "-o", tmp_path / "out")
    assert "cuts, feed 0.1" in done.stdout and (tmp_path / "out" / "report.html").stat().st_size < 2_000_000


def test_one_feed_needs_the_exponent(call, refused, cuts):
    path = cuts("0.2,1,400", "0.2,2,810", "0.2,3,1190")
    assert "one feed says nothing about the exponent" in refused(*NAME, path)
    said = call(*NAME, path, "--exponent", 0.8)
    assert "given" in said.stdout and "was given, not fitted" in said.stderr


REFUSED = {
    "missing column": ("feed,width,force", ["0.1,1,200", "0.2,1,350", "0.4,1,600"], "no column is the depth"),
    "negative feed": ("feed,depth,force", ["0.1,1,200", "-0.2,1,350", "0.4,1,600"], "-0.2 is not above 0"),
    "two points": ("feed,depth,force", ["0.1,1,200", "0.2,1,350"], "expected at least 3"),
    "zero force": ("feed,depth,force", ["0.1,1,0", "0.2,1,350", "0.4,1,600"], "0 is not above 0; a row without a cut"),
    "not a number": ("feed,depth,force", ["0.1,1,nan", "0.2,1,350", "0.4,1,600"], "'nan' is not a finite number"),
    "metres": ("feed,depth,force", ["0.1,0.001,200", "0.2,0.001,350", "0.4,0.001,600"], "--unit depth=m"),
    "header twice": ("feed,feed,depth,force", ["0.1,0.1,1,200"], "are both the feed"),
    "no rows": ("feed,depth,force", [], "has a header but no rows"),
    "the same cut three times": ("feed,depth,force", ["0.1,1,200"] * 3, "after leaving out repeats"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_a_table_that_cannot_be_used_is_refused_in_one_sentence_and_writes_nothing(refused, cuts, tmp_path, name):
    header, lines, says = REFUSED[name]
    assert says in refused(*NAME, cuts(*lines, header=header), "-o", tmp_path / "out")
    assert [p.name for p in tmp_path.iterdir()] == ["cuts.csv"]


@pytest.mark.parametrize(
    ("more", "says"),
    [
        (["--at", "0.1"], "--at 0.1: expected FEED,DEPTH, two numbers above 0"),
        (["--at", "0.1,-1"], "two numbers above 0"),
        (["--beside", "1600"], "--beside 1600: expected KC11,MC"),
        (["--column", "feed"], "--column 'feed': expected WHAT=HEADER"),
        (["--unit", "feed=mm", "--unit", "feed=m"], "--unit feed: given twice"),
        (["--usual-kc", "9,2"], "LOW below HIGH"),
        (["--method", "best"], "allowed are log-log, relative, absolute"),
        (["--kappa", 0], "(0, 90]"),
        (["--spindle-rpm", -1], "--spindle-rpm = -1"),
        (["--bootstrap", 3], "100 to 1000000"),
    ],
)
def test_options_that_make_no_sense_are_refused(refused, more, says):
    assert says in refused(*NAME, PUBLISHED, *more)


def test_the_example_is_the_one_of_the_examples_and_overwrites_nothing(call, refused, tmp_path):
    path = tmp_path / "forces.csv"
    assert "next: leadscrew identify cutting-force" in call(*NAME, path, "--example").stdout
    assert path.read_text(encoding="utf-8") == PUBLISHED.read_text(encoding="utf-8")
    assert "exists already" in refused(*NAME, path, "--example")
    assert "only writes FILE" in refused(*NAME, tmp_path / "x.csv", "--example", "--json")


def test_an_empty_or_absent_file_is_refused(refused, tmp_path):
    (tmp_path / "none.csv").write_text("", encoding="utf-8")
    assert "is empty" in refused(*NAME, tmp_path / "none.csv")
    assert "cannot be read" in refused(*NAME, tmp_path / "absent.csv")
