"""Linear models from logs: known systems give their numbers back, the untold is said, bad logs are refused."""

import json

import numpy as np
import pytest
from scipy import signal
from typer.testing import CliRunner

from leadscrew.cli import app
from leadscrew.identify.linear.fit import identify_linear
from leadscrew.identify.linear.model import forced, free, sampled_response, step_of
from leadscrew.identify.linear.record import linear_record, read_linear
from leadscrew.identify.linear.result import block, limits, machine_values
from leadscrew.identify.linear.servo_gain import servo_gain
from leadscrew.studies.vud_lathe.laws import TABLE_1, gain_fits, moves
from leadscrew.util.errors import DataError, NameUnknown, ValueRefused

T = 1e-3


def levels(rng, samples, longest=60):
    """Random levels, held for random times."""
    found = np.concatenate([np.full(int(rng.integers(3, longest)), rng.normal()) for _ in range(samples)])
    return found[:samples]


def finer(numerator, denominator, u, delay, steps=10):
    """The output by SciPy's discretisation at a finer period, with a delay of whole finer periods."""
    a, b, c, *_ = signal.cont2discrete(signal.tf2ss(np.trim_zeros(numerator, "f"), denominator), T / steps)
    late = round(delay / (T / steps))
    fine = np.concatenate([np.full(late, u[0]), np.repeat(u, steps)])[: len(u) * steps]
    x, y = np.zeros(len(a)), np.empty(len(u))
    for k, value in enumerate(fine):
        if k % steps == 0:
            y[k // steps] = (c @ x).item()
        x = a @ x + b[:, 0] * value
    return y


def axis(rng, samples=1600, noise=0.02):
    """Speed gain 5, poles at -40 and 0, delay 2.3 periods, an input offset of 0.2, noise and counts."""
    u = levels(rng, samples)
    clean = finer([200.0], [1.0, 40.0, 0.0], u + 0.2, 2.3e-3)
    scale = noise * clean.std()
    return T * np.arange(samples), u, np.round((clean + rng.normal(0.0, scale, samples)) / (0.5 * scale)) * 0.5 * scale


def test_the_answer_to_a_held_input_with_part_of_a_period_of_delay_is_that_of_finer_steps():
    u = levels(np.random.default_rng(1), 300)
    denominator = np.real(np.poly([0.0, -7.0, -30.0 + 200.0j, -30.0 - 200.0j]))
    step = step_of(denominator, 3.7e-3, T)
    states = forced(step, u)
    for power in range(4):
        expected = finer(np.eye(4)[3 - power], denominator, u, 3.7e-3)
        assert states[:, power] * step.rate ** (power - 4) == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())
    begun = free(step, 300)
    assert begun[257] == pytest.approx(np.linalg.matrix_power(step.transition, 257)[0], abs=1e-9)


def test_the_sampled_response_is_that_of_a_sine_of_samples():
    denominator, hz = np.array([1.0, 20.0, 900.0]), 10.0
    step = step_of(denominator, 1.4e-3, T)
    t = T * np.arange(4000)
    u = np.sin(2.0 * np.pi * hz * t)
    late = forced(step, u)[2000:, 0]
    expected = 2.0 * np.mean(late * np.exp(-2j * np.pi * hz * t[2000:])) * 1j
    assert sampled_response(step, np.array([1.0, 0.0]), T, np.array([hz]))[0] == pytest.approx(expected, rel=1e-6)


def test_one_log_gives_gain_pole_delay_and_offset_back_within_their_intervals():
    t, u, y = axis(np.random.default_rng(3))
    before = y.copy()
    fit = identify_linear(linear_record(t, u, y), structure=(2, 0, 1))
    truth = {"gain": 5.0, "pole 1": -40.0, "delay_s": 2.3e-3}
    for name, value in truth.items():
        found = fit.parameters[name]
        assert found.low <= value <= found.high
        assert found.percent < (20.0 if name == "delay_s" else 10.0)
    assert fit.offset.low <= -0.2 <= fit.offset.high
    assert fit.coefficients["b0"].low <= 200.0 <= fit.coefficients["b0"].high
    assert fit.stretch("hold-out").rms == pytest.approx(0.02 * fit.stretch("hold-out").measured.std(), rel=0.5)
    assert (y == before).all()
    assert fit.denominator[-1] == 0.0
    assert np.abs(fit.response([3.0])[0]) == pytest.approx(200.0 / abs((6j * np.pi) ** 2 + 40.0 * 6j * np.pi), rel=0.05)
    json.dumps(fit.as_dict(), allow_nan=False)


def test_the_block_of_a_fit_and_its_machine_values_are_the_fit():
    t, u, y = axis(np.random.default_rng(4))
    record = linear_record(t, u, y, input_unit="V", output_unit="mm")
    fit = identify_linear(record, structure=(2, 0, 1))
    told = machine_values(fit)
    assert (told["kind"], told["position_unit"], told["drive_unit"], told["period"]) == (
        "linear",
        "mm",
        "V",
        record.period,
    )
    assert np.sort(np.roots(told["denominator"])) == pytest.approx(
        np.sort(np.linalg.eigvals(block(fit).params.a)), abs=1e-6
    )
    assert limits(fit)["travel"] == [y.min(), y.max()]
    assert limits(fit)["drive"] == np.abs(u).max()


def noisy_loop(seed=1, samples=6000):
    """Time, input, output and command of a pole at -30 under a gain of 4, with noise of 10 ms memory on its output."""
    rng = np.random.default_rng(seed)
    plant, gain = np.exp(-30.0 * T), 3.0
    r, noise = levels(rng, samples, 200), np.zeros(samples)
    for k in range(1, samples):
        noise[k] = 0.9 * noise[k - 1] + 0.15 * rng.normal()
    u, y, x = np.empty(samples), np.empty(samples), 0.0
    for k in range(samples):
        y[k] = x + noise[k]
        u[k] = 4.0 * (r[k] - y[k])
        x = plant * x + gain * (1.0 - plant) * u[k]
    return T * np.arange(samples), u, y, r


@pytest.mark.slow
def test_noise_that_goes_round_a_loop_biases_output_error_and_not_the_instruments():
    t, u, y, r = noisy_loop()
    plain, told = (
        identify_linear(linear_record(t, u, y, c), structure=(1, 0, 0), delay=0.0, holdout=0.0) for c in (None, r)
    )
    pole = plain.parameters["pole 1"]
    assert abs(pole.value + 30.0) > pole.high - pole.value + 2.0
    assert any("from a closed loop" in note for note in plain.notes)
    assert told.closed_loop
    assert told.parameters["pole 1"].low <= -30.0 <= told.parameters["pole 1"].high


@pytest.mark.slow
def test_what_a_log_does_not_tell_is_said():
    t = T * np.arange(3000)
    u = np.sin(2.0 * np.pi * 0.7 * t)
    y = finer([3e5], np.polymul([1.0, 10.0], [1.0, 3e4]), u, 0.0, 2) + np.random.default_rng(0).normal(0.0, 0.02, 3000)
    fit = identify_linear(linear_record(t, u, y), structure=(2, 0, 0))
    assert not fit.parameters["pole 2" if "pole 2" in fit.parameters else "damping 1"].identifiable
    assert fit.excited_hz[1] < 10.0
    assert any("not identifiable" in note or "hardly tells" in note for note in fit.notes)
    assert any("repeats the move" in note for note in fit.notes)
    assert fit.advice


def test_bad_logs_and_options_are_refused_in_one_sentence(tmp_path):
    t, u, y = axis(np.random.default_rng(5), 200)
    for bad, says in (
        ((t, 0.0 * u, y), "input input is 0 from first to last"),
        ((t, u, 0.0 * y + 3.0), "output output is 3"),
        ((t[:2], u[:2], y[:2]), "2 samples"),
        ((t, u[:-1], y), "unequal lengths"),
        ((t, u, np.where(t == t[7], np.nan, y)), "sample 8, is nan"),
        ((t, u, u), "output is input"),
        ((np.where(t > 0.1, t + 0.05, t), u, y), "gap|samples are missing|not evenly|s after|missing"),
    ):
        with pytest.raises(DataError, match=says):
            linear_record(*bad)
    record = linear_record(t, u, y)
    for options, says in (
        ({"structure": (2, 2, 0)}, "zeros"), ({"holdout": 0.9}, "holdout"), ({"margin": -1.0}, "margin"),
        ({"delay": -1.0}, "delay"), ({"max_order": 9}, "max_order"), ({"integrators": (3,)}, "integrators"),
    ):  # fmt: skip
        with pytest.raises(ValueRefused, match=says):
            identify_linear(record, **options)
    path = tmp_path / "log.csv"
    path.write_text("time,u (V),y (mm)\n" + "\n".join(f"{a},{b},{c}" for a, b, c in zip(t, u, y, strict=True)) + "\n")
    read = read_linear(path, "u", "y", start=0.05)
    assert (read.input_unit, read.output_unit, read.input_name) == ("V", "mm", "u")
    assert read.time[0] == pytest.approx(0.05)
    with pytest.raises(NameUnknown, match="no column 'z'"):
        read_linear(path, "u", "z")
    with pytest.raises(ValueRefused, match="different columns"):
        read_linear(path, "u", "u")


def test_servo_gain_gives_the_lathe_study_its_number():
    expected = gain_fits(moves())
    found = servo_gain(
        [TABLE_1], "rho", "e", time="k", split="r", lags_s=(0.0008, 0.0015, 0.017), units={"k": "0.1 s", "e": "-190 mm"}
    )
    assert found.gain == pytest.approx(expected["linear"].gain, rel=1e-12)
    assert [m.gain_alone for m in found.moves] == pytest.approx(list(expected["linear"].gain_alone.values()), rel=1e-12)
    assert found.other_holds == pytest.approx({h: expected[h].gain for h in ("previous", "current")}, rel=1e-12)
    assert found.unit == "mm/s"
    assert any("not linear" in note for note in found.notes)
    with pytest.raises(ValueRefused, match="hold = 'guess'"):
        servo_gain([TABLE_1], "rho", "e", time="k", hold="guess")
    with pytest.raises(NameUnknown, match="no column 'duty'"):
        servo_gain([TABLE_1], "duty", "e", time="k")


@pytest.mark.slow
def test_the_command_writes_a_report_and_a_machine_and_says_what_it_found(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    t, u, y = axis(np.random.default_rng(6), 1000)
    table = np.column_stack([t, u, y])
    np.savetxt("log.csv", table, delimiter=",", header="time (s),u (V),y (mm)", comments="")
    command = ["identify", "linear", "log.csv", "--input", "u", "--output", "y", "--order", "2,0,1", "--report", "out"]
    command += ["-o", "axis.toml", "--json"]
    done = CliRunner().invoke(app, command)
    assert done.exit_code == 0, done.output
    found = json.loads(done.stdout)
    assert found["schema_version"] == 1
    assert found["parameters"]["gain"]["low"] <= 5.0 <= found["parameters"]["gain"]["high"]
    names = sorted(p.name for p in (tmp_path / "out").iterdir())
    assert names == ["linear.json", "linear_bode.png", "linear_residual.png", "linear_simulated.png", "report.html"]
    assert "exp(-" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    again = CliRunner().invoke(app, command)
    assert again.exit_code == 2
    assert "exists already" in again.stderr
    from leadscrew.machine.file import read

    machine = read(tmp_path / "axis.toml")
    assert machine.parameters["denominator"] == found["denominator"]
    for wrong in ("--order 1.5", "--order 1,2,3,4", "--integrators a", "--unit u"):
        refused = CliRunner().invoke(
            app, ["identify", "linear", "log.csv", "--input", "u", "--output", "y", *wrong.split()]
        )
        assert refused.exit_code == 2, refused.output


def test_files_whose_units_differ_are_refused_not_fitted_as_one(tmp_path):
    rows = "\n".join(f"{k / 10},{k % 2},{k * 0.1}" for k in range(30))
    for name, unit in (("a.csv", "mm"), ("b.csv", "um")):
        (tmp_path / name).write_text(f"time,u,x [{unit}]\n{rows}\n")
    with pytest.raises(DataError, match=r"b\.csv: 'u' is in 1 and 'x' in um, in the files before it in 1 and mm"):
        servo_gain([tmp_path / "a.csv", tmp_path / "b.csv"], "u", "x")
