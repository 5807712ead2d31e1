"""What a page may say: everything else is refused in one sentence."""

import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from leadscrew.panel import strict_json
from leadscrew.panel.messages import ALL, READERS, WRITERS, Refused, parse

GOOD = {
    "hello": {"name": "Ann", "secret": "s" * 16, "since": None},
    "speed": {"value": 0.5}, "machine": {"study": "vud_lathe"}, "switch": {"controller": "ours.pd"},
    "set": {"changes": {"controller.kp": 1.5, "controller.on": True, "controller.law": "back-calculation",
                        "plant.table": [[1.0, 2], [3, 4]]}},
    "compare": {"mode": "pinned"}, "disturb": {"name": "load_pulse", "fields": {"size": 3}},
    "arm": {"signal": "error", "level": 0.1, "slope": "rising", "mode": "single", "pre": 0.2, "length_s": 1},
    "capture_save": {"name": "a b-1_2.c", "format": "csv"}, "capture_load": {"name": "a.csv"},
    "preset_save": {"name": "a"}, "preset_load": {"name": "a"}, "preset_delete": {"name": "a"},
    "session_save": {"name": "a"}, "audit": {"last": 3}, "why": {"views": ["rules"]}, "ping": {"t": 1.5},
}  # fmt: skip


def said(do, **args):
    return json.dumps({"id": 7, "do": do, **args})


@pytest.mark.parametrize("do", sorted(ALL))
def test_every_command_of_the_page_is_understood(do):
    message = parse(said(do, **GOOD.get(do, {})))
    assert (message.id, message.do) == (7, do)
    assert set(GOOD.get(do, {})) <= set(message.args())


@pytest.mark.parametrize("do", sorted(ALL))
def test_a_field_that_is_not_known_is_refused(do):
    with pytest.raises(Refused, match="extra inputs"):
        parse(said(do, **GOOD.get(do, {}), surprise=1))


def test_what_changes_the_machine_is_for_the_writer_alone():
    assert not set(READERS) & set(WRITERS)
    assert {"set", "start", "stop", "machine", "switch", "disturb", "preset_delete", "session_save"} <= set(WRITERS)


@pytest.mark.parametrize(
    "text, why",
    [
        ('{"id":1,"do":"ping","t":NaN}', "NaN is not allowed"),
        ('{"id":1,"do":"ping","t":-Infinity}', "-Infinity is not allowed"),
        ('{"id":1,"do":"ping","t":1e400}', "beyond what a machine can hold"),
        ('{"id":1,"do":"ping","t":' + "9" * 5000 + "}", "5000 digits"),
        ('{"id":1,"do":"stop","do":"start"}', "is repeated"),
        ('{"id":1,"do":"set","changes":{"a":1,"a":2}}', "is repeated"),
        ("[" * 100_000, "nested deeper"),
        ('{"a":' * 20_000, "nested deeper"),
        ("[]", "no JSON object"),
        ("", "no JSON"),
        ('{"id":1,"do":"ping","t":1}x', "no JSON"),
        ('{"id":1}', "no command"),
        ('{"id":1,"do":["set"]}', "no command"),
        ('{"id":1,"do":"sett"}', "did you mean set"),
        ('{"id":1,"do":"__class__"}', "no command"),
    ],
)
def test_json_with_surprises_is_refused(text, why):
    with pytest.raises(Refused, match=why):
        parse(text)


@pytest.mark.parametrize(
    "do, args",
    [
        ("speed", {"value": "1"}), ("speed", {"value": True}), ("set", {"changes": {}}),
        ("set", {"changes": {"a b": 1}}),
        ("set", {"changes": {"controller.kp": "0.5"}}), ("set", {"changes": {"controller.law": "a<b"}}),
        ("set", {"changes": {"controller.kp": None}}),
        ("set", {"changes": {"controller.kp": {"x": 1}}}), ("set", {"changes": {f"a{i}": 1 for i in range(257)}}),
        ("set", {"changes": {"t": [0.0] * 513}}), ("arm", {"signal": "error", "level": 0.0, "pre": 2.0}),
        ("arm", {"signal": "error", "level": 0.0, "slope": "up"}), ("audit", {"last": 10**9}), ("audit", {"last": 0}),
        ("machine", {"study": 3}), ("machine", {"study": "a", "seed": -1}), ("why", {"views": ["rules"] * 5}),
        ("hello", {"name": ""}), ("hello", {"name": "A", "secret": "short"}), ("hello", {"name": "A" * 41}),
        *[(do, {"name": name}) for do in ("preset_save", "session_save", "preset_load", "capture_load", "capture_save")
          for name in ("../x", "/etc/passwd", "", ".x", "a/b", "a\\b", "a\nb", "a\n", "x" * 80, "a\x00b", "ä", "..",
                       "%2e%2e")],
    ],
)  # fmt: skip
def test_a_value_of_another_kind_is_refused(do, args):
    with pytest.raises(Refused) as refused:
        parse(said(do, **args))
    assert refused.value.id == 7 and str(refused.value).startswith(do) and len(str(refused.value)) < 300


def test_a_refused_hello_never_repeats_the_secret():
    for bad in ({"secret": 12345678901234567}, {"secret": "tell-nobody" * 30}, {"secret": "tell-nobody"}, {"name": 3}):
        with pytest.raises(Refused) as refused:
            parse(said("hello", **{"name": "Ann", "secret": "tell-nobody-too-01", **bad}))
        assert "nobody" not in str(refused.value) and "1234567" not in str(refused.value)


def test_a_refused_value_names_its_key():
    with pytest.raises(Refused) as refused:
        parse(said("set", changes={"controller.ki": 1.0, "controller.kp": "1 V"}))
    assert refused.value.key == "controller.kp" and "expected a number" in str(refused.value)


anything = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=10), inner, max_size=4),
    max_leaves=12,
)


@given(st.text(max_size=200) | anything.map(json.dumps))
def test_no_message_breaks_the_reader(text):
    try:
        parse(text)
    except Refused as refused:
        assert str(refused)


fields = st.sampled_from(
    ["name", "value", "changes", "views", "study", "fields", "level", "signal", "t", "mode", "last"]
)


@pytest.mark.slow
@given(st.sampled_from(sorted(ALL)), st.dictionaries(fields, anything))
def test_what_is_let_through_has_only_finite_numbers(do, args):
    try:
        message = parse(said(do, **args))
    except Refused:
        return
    json.dumps(message.args(), allow_nan=False)


@given(anything)
def test_plain_json_means_the_same_to_us_and_to_python(value):
    text = json.dumps({"a": value})
    try:
        found = strict_json.loads(text)
    except ValueError:
        return
    assert found == json.loads(text)


def test_depth_is_of_brackets_and_not_of_texts():
    assert strict_json.loads(json.dumps({"a": "[" * 500 + '\\"{'})) == {"a": "[" * 500 + '\\"{'}
    assert strict_json.loads(json.dumps({"a": '"' + "[" * 500})) == {"a": '"' + "[" * 500}
    with pytest.raises(ValueError, match="deeper"):
        strict_json.loads(json.dumps({"a/": "\\", "b": [[[[[[[["/"]]]]]]]]}))
    assert strict_json.loads('{"a":[[[[[[[1]]]]]]]}')
    with pytest.raises(ValueError, match="deeper"):
        strict_json.loads('{"a":[[[[[[[[1]]]]]]]]}')
    assert math.isclose(strict_json.loads('{"a":1e308}')["a"], 1e308)
