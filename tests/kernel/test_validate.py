"""What goes into a loop wrong is refused at the door, by value, range and place."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from leadscrew.kernel import validate
from leadscrew.kernel.loop import Loop
from leadscrew.kernel.metrics import STANDARD
from leadscrew.util.errors import BlockError, NameUnknown, ValueRefused
from tests.kernel import zoo

GOOD = {"reference": zoo.sine, "controller": zoo.pid, "plant": zoo.mass, "metrics": {}}


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"period": 0.0}, r"period = 0.0: allowed range is \(0, inf\) s"),
        ({"period": -1.0}, "period = -1.0"),
        ({"period": math.nan}, "NaN"),
        ({"period": "fast"}, "period = 'fast': expected a number"),
        ({"substeps": 0}, "substeps = 0: allowed are whole numbers from 1"),
        ({"substeps": 2.5}, "substeps = 2.5"),
        ({"computation_delay": 0.0004}, "not a multiple of the integration step of 0.001 s"),
        ({"transport_delay": -1e-3}, "transport_delay = -0.001: allowed range"),
        ({"transport_delay": math.inf}, "transport_delay"),
        ({"method": "rk5"}, "method = 'rk5': allowed are rk4, sdirk3, rodas; did you mean rk4"),
        ({"engine": "fortran"}, "engine = 'fortran'"),
        ({"bound": 0}, "bound = 0"),
        ({"seed": -3}, "seed = -3"),
        ({"rtol": 0.0}, "rtol"),
        ({"plant": zoo.pid}, "'pid' is a controller, not a plant"),
        ({"controller": lambda: 0}, "is a function, not a block; decorate it with @controller"),
        ({"reference": None}, "a loop needs a reference"),
        ({"metrics": {"not a word": STANDARD["iae"]}}, "must be a word"),
        ({"metrics": {"x": zoo.pid}}, "not a metric block"),
        ({"period": None}, "sampled controller"),
        ({"output_disturbance": zoo.pid}, "not a disturbance"),
    ],
)
def test_what_is_wrong_is_refused_with_value_range_and_place(changes, says):
    with pytest.raises((ValueRefused, BlockError), match=says):
        Loop(**{**GOOD, **changes})


@pytest.mark.parametrize(
    ("key", "value", "error", "says"),
    [
        ("controller.kp", -1.0, ValueRefused, r"controller.kp = -1.0: allowed range is \[0, inf\) V/mm"),
        ("controller.kp", math.nan, ValueRefused, "controller.kp = nan: not a number"),
        ("controller.kp", "1", ValueRefused, "controller.kp = '1': expected a number in V/mm; write 1 without quotes"),
        ("controller.kq", 1.0, NameUnknown, "there is no parameter 'controller.kq'; did you mean .*controller.kp"),
        ("controler.kp", 1.0, NameUnknown, "controller.kp"),
        ("plant.mass", 0, ValueRefused, r"plant.mass = 0: allowed range is \(0, inf\) kg"),
    ],
)
def test_a_bad_parameter_is_refused_by_its_dotted_key(key, value, error, says):
    with pytest.raises(error, match=says):
        Loop(**GOOD).using({key: value})


def test_options_and_durations_are_checked():
    loop = Loop(**GOOD)
    with pytest.raises(NameUnknown, match="seed, engine, bound, name"):
        loop.using(period=1.0)
    assert loop.using(seed=4, bound=3.0, engine="python", name="x").seed == 4
    for bad, says in (
        (0.0, "allowed range"),
        (1e-5, "shorter than one period"),
        (math.nan, "NaN"),
        (1e18, "2.53 periods"),
    ):
        with pytest.raises(ValueRefused, match=says):
            loop.run(bad)
    with pytest.raises(ValueRefused, match="record fewer signals, or every="):
        loop.run(1e9)
    with pytest.raises(ValueRefused, match="whole numbers"):
        loop.start().advance(0)
    with pytest.raises(ValueRefused, match="engine"):
        loop.run(1.0, engine="x")
    with pytest.raises(ValueRefused, match="another shape"):
        loop.start().restore(Loop(**{**GOOD, "controller": zoo.observed}).start().save())


@pytest.mark.parametrize(
    ("varied", "more", "says"),
    [
        ({"controller.kp": [1.0, -2.0]}, {}, "controller.kp = -2.0"),
        ({"controller.kp": [1.0, math.nan]}, {}, "NaN"),
        ({"controller.kp": ["a"]}, {}, "expected an array of numbers"),
        ({"controller.kp": [[1.0, 2.0]]}, {}, "expected the shape"),
        ({"controller.kp": []}, {}, "no value to run"),
        ({"controller.kp": [1.0, 2.0], "controller.kd": [1.0, 2.0, 3.0]}, {}, "same number of values"),
        ({"controller.kp": [1.0, 2.0]}, {"runs": 3}, "same number of values"),
        ({}, {"runs": 0}, "runs"),
        ({}, {"threads": 0}, "threads"),
        ({}, {"runs": 100000, "record": "actual", "engine": "llvm"}, "needs .* GB"),
    ],
)
def test_a_bad_batch_is_refused(varied, more, says):
    with pytest.raises(ValueRefused, match=says):
        Loop(**GOOD).batch(30.0, varied, **more)


@settings(max_examples=60, deadline=None)
@given(
    st.one_of(
        st.floats(), st.integers(), st.text(max_size=5), st.none(), st.booleans(), st.lists(st.floats(), max_size=2)
    )
)
def test_no_value_gets_through_the_door_half_checked(value):
    loop = Loop(**GOOD)
    try:
        new = loop.using({"controller.kp": value})
    except ValueRefused as error:
        assert "controller.kp" in str(error) and "\n" not in str(error)
    else:
        kp = new.parameters["controller.kp"]
        assert isinstance(kp, float) and kp >= 0


@settings(max_examples=60, deadline=None)
@given(st.one_of(st.floats(), st.integers(), st.text(max_size=5), st.none(), st.booleans()))
def test_no_period_gets_through_the_door_that_is_not_a_time(value):
    try:
        loop = Loop(**{**GOOD, "period": value, "controller": zoo.pid}) if value is not None else None
    except (ValueRefused, BlockError) as error:
        assert "\n" not in str(error)
    else:
        assert loop is None or 0 < loop.period < math.inf


def test_the_door_names_numbers():
    assert validate.number("x", 3, "mm") == 3.0
    with pytest.raises(ValueRefused, match="x = True: expected a number in mm"):
        validate.number("x", True, "mm")


def test_a_whole_number_may_be_either_end_of_its_range_and_nothing_beyond():
    assert [validate.whole("run", x, 0, 7) for x in (0, 7, 7.0)] == [0, 7, 7]
    for x in (-1, 8, 6.5):
        with pytest.raises(ValueRefused, match="allowed are whole numbers from 0 to 7"):
            validate.whole("run", x, 0, 7)


def test_ten_hours_are_a_whole_number_of_steps_although_their_product_is_rounded():
    # 360007000 * 1e-4 is 7e-12 s beside 36000.7 s: one unit in the last place of a double.
    assert validate.in_steps("duration", 36000.7, 1e-4) == 360_007_000
    with pytest.raises(ValueRefused, match=r"the nearest is 0\.001 s"):
        validate.in_steps("duration", 1.0000001e-3, 1e-3)
