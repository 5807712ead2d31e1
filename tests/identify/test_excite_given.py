"""Test moves from what is known already: a fit, a machine file, a log; and the command."""

import json
import math
import re

import pytest
from typer.testing import CliRunner

from leadscrew.cli import app
from leadscrew.identify.excite import propose
from leadscrew.identify.excite.belief import belief_of, keys_of
from leadscrew.identify.excite.files import Machine
from leadscrew.util.errors import DataError, ValueRefused
from tests.identify.excite_beliefs import LIMITS, believed


def of_fit(value, unit, low=None, high=None, how="fixed", told=False):
    return {"value": value, "unit": unit, "low": low, "high": high, "how": how, "told": told}


FIT = {
    "parameters": {
        "mass": of_fit(95.0, "kg", 94.0, 96.0, "fitted", True),
        **{f"friction.{s}.coulomb": of_fit(20.0, "N", 1.0, 40.0, "fitted") for s in ("forward", "backward")},
        **{f"friction.{s}.viscous": of_fit(200.0, "N s/m") for s in ("forward", "backward")},
        "force_per_drive": of_fit(35.0, "N/V", how="given", told=True),
    },
    "symmetric": True, "position_unit": "m", "drive_unit": "V", "period_s": 0.001, "travel": [0.0, 0.25],
    "top_speed": 0.2, "top_acceleration": 2.0, "encoder_step": 1e-6, "noise": 2e-6, "judged": [{"rms_force": 0.5}],
    "missing": ["friction.forward.viscous", "friction.backward.viscous"],
}  # fmt: skip


@pytest.mark.slow
def test_a_fit_says_what_is_missing_and_what_the_axis_did_and_so_may_do(tmp_path):
    (tmp_path / "fit.json").write_text(json.dumps({"schema_version": 1, **FIT}))
    belief, limits = belief_of(tmp_path / "fit.json")
    assert belief.wanted == tuple(FIT["missing"]) and belief.force_noise == 0.5 and belief.noise == 2e-6
    assert limits[:4] == (0.0, 0.25, 0.2, 2.0) and belief.known["mass"] == pytest.approx(2.0 / 3.92, rel=1e-4)
    assert propose(limits, belief).predicted[0].verdict == "identifiable"
    more, _ = belief_of(tmp_path / "fit.json", ["static", "backlash", "presliding"])
    assert more.of("friction.forward.static") == pytest.approx(26.0) and more.of("backlash") == pytest.approx(6e-5)
    assert more.of("friction.backward.stribeck_speed") == pytest.approx(0.004)
    assert propose(limits._replace(duration=120.0), more).parts.keys() >= {"reverse", "bend", "shiver"}
    (tmp_path / "no.json").write_text("{}")
    with pytest.raises(DataError, match="is no fit of an axis"):
        belief_of(tmp_path / "no.json")


@pytest.mark.slow
def test_the_command_prints_one_json_object_and_refuses_before_it_works(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "fit.json").write_text(json.dumps(FIT))
    done = CliRunner().invoke(app, ["excite", "fit.json", "--tell", "mass", "--json", "-o", "test"])
    assert done.exit_code == 0, done.output
    seen = json.loads(done.stdout)
    assert seen["kind"] == "leadscrew excite" and [p["key"] for p in seen["predicted"]] == ["mass"]
    assert (tmp_path / "test" / "move.ngc").exists()
    for arguments, said in (
        (["fit.json", "-o", "test"], "exists already"),
        ([], "--travel, --top-speed, --top-acceleration: needed"),
        (["fit.json", "--travel", "5"], "--travel '5'"),
        (["fit.json", "--signals", "a,b"], "--signals 'a,b'"),
        (["fit.json", "--unit", "deg"], "the fit is in m"),
    ):
        done = CliRunner().invoke(app, ["excite", *arguments])
        assert done.exit_code == 2 and said in done.stderr, (arguments, done.output)


MACHINE = """schema_version = 1
kind = "machine"
name = "mill"
model = "servo_axis"
position_unit = "mm"
drive_unit = "V"
period = 0.001
delay_s = 0.0005
resolution = 0.001
noise = 0.002
[limits]
drive = 10.0
speed = 200.0
acceleration = 2000.0
travel = [0.0, 250.0]
[set]
mass = 95.0
force_per_drive = 35.0
offset = 0.0
friction.forward.coulomb = 20.0
friction.forward.viscous = 200.0
friction.forward.static = 20.0
friction.forward.stribeck_speed = 0.001
friction.backward.coulomb = 22.0
friction.backward.viscous = 210.0
friction.backward.static = 22.0
friction.backward.stribeck_speed = 0.001
[interval]
mass = [94.0, 96.0]
friction.forward.viscous = [120.0, 280.0]
[identified]
symmetric = false
[identified.training]
rms_force = 0.5
[identified.fixed]
offset = "fixed at 0"
backlash = "closed on this encoder"
force_per_drive = "given"
friction.forward.static = "no rise"
friction.backward.static = "no rise"
"""


def test_a_machine_file_gives_values_sensor_limits_and_what_its_log_did_not_tell(tmp_path):
    path = tmp_path / "mill.toml"
    path.write_text(MACHINE)
    belief, limits = belief_of(path)
    assert limits[:4] == pytest.approx((0.0, 0.25, 0.2, 2.0))
    assert belief.wanted == ("friction.forward.viscous", "friction.forward.static", "friction.backward.static")
    assert belief.noise == pytest.approx(math.hypot(2e-6, 1e-6 / math.sqrt(12.0)))
    assert belief.force_noise == 0.5 and not belief.symmetric
    assert (belief.unit, belief.force_unit, belief.drive_unit, belief.of("delay_s")) == ("m", "N", "V", 0.0005)
    assert set(belief.known) == {"mass"} and belief.known["mass"] == pytest.approx(2.0 / 3.92, rel=1e-4)
    # 1 mm/s in the file says nothing where friction does not rise: 2 % of the top speed, 1.3 times Coulomb friction.
    assert belief.of("friction.forward.stribeck_speed") == pytest.approx(0.004)
    assert belief.of("friction.backward.static") == pytest.approx(28.6)
    more, _ = belief_of(path, ["friction"], {"coulomb": 30.0})
    assert more.wanted == keys_of(["friction"]) and more.of("friction.backward.coulomb") == 30.0
    path.write_text(MACHINE.replace("force_per_drive = 35.0", "force_per_drive = 1.0"))
    assert belief_of(path)[0].force_unit == "V"
    path.write_text(MACHINE.split("[interval]")[0])
    with pytest.raises(ValueRefused, match="nothing is missing"):
        belief_of(path)
    path.write_text(MACHINE.replace('"servo_axis"', '"linear"'))
    with pytest.raises(DataError, match="linear machine, without mass and friction"):
        belief_of(path)
    path.write_text(MACHINE.replace("mass = 95.0", 'mass = "heavy"'))
    with pytest.raises(DataError, match="mass = 'heavy'"):
        belief_of(path)


@pytest.mark.parametrize(
    ("limits", "belief", "said"),
    [
        (LIMITS._replace(high=5e-5), believed("mass"), "50 times the sensor's noise .* --travel"),
        (LIMITS._replace(speed=1e-9), believed("mass"), "--top-speed"),
        # Sampling such a stroke would take years: it must be refused before.
        (LIMITS._replace(acceleration=1e-9, jerk=0.0), believed("mass"), "the shortest test takes"),
        (LIMITS, believed("presliding", coulomb=0.0, static=0.0), "--guess coulomb=VALUE"),
    ],
)
def test_limits_of_a_log_that_hardly_moved_and_bristles_without_friction_are_refused(limits, belief, said):
    with pytest.raises(ValueRefused, match=said):
        propose(limits, belief)


def test_strokes_on_bristles_stay_below_the_weaker_of_both_directions():
    from leadscrew.identify.excite.design import candidates

    belief = believed("presliding", symmetric=False)
    belief.values.update({"friction.backward.static": 10.0, "friction.backward.coulomb": 8.0})
    (bend,) = (p for p in candidates(LIMITS, belief) if p.name == "bend")
    reach = max(abs(s.end - 0.15) for s in bend.move.strokes)
    assert reach == pytest.approx(0.7 * 10.0 / 1e6, rel=1e-3)


def test_what_hides_a_rise_of_friction_is_the_force_left_where_that_is_larger_than_the_sensor_s_noise():
    from leadscrew.identify.excite.design import why_not

    belief = believed("stribeck", force_noise=2.0)
    said = why_not("friction.forward.stribeck_speed", belief, 1.0, 0.001, LIMITS, 30.0)
    assert "rises by 8 N" in said and "a force of 2" in said and "sensor" not in said


def test_the_header_of_the_log_has_the_drive_unit_without_a_blank():
    from leadscrew.identify.excite.files import checked, header

    class Shown:
        belief = believed("mass")

    assert header(Shown, checked(Machine("A", drive_unit="N m"))).endswith("drive [Nm]")


@pytest.mark.slow
def test_a_rotary_machine_is_recorded_as_axis_a_in_its_own_drive_unit(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    turned = MACHINE.replace('"mm"', '"deg"').replace('"V"', '"N m"').replace("mass = 95.0", "mass = 0.02")
    (tmp_path / "table.toml").write_text(turned)
    done = CliRunner().invoke(app, ["excite", "table.toml", "--tell", "mass", "-o", "test"])
    assert done.exit_code == 0, done.output
    assert "log of table.toml" in done.stderr
    assert "drive [Nm]" in (tmp_path / "test" / "record.sh").read_text()
    assert re.search(r"^G1 A[-\d.]+ F", (tmp_path / "test" / "move.ngc").read_text(), re.M)
