"""Whatever a file holds, it is read or refused in a sentence, and soon."""

import gc
import re
import time
from datetime import timedelta

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from leadscrew.fuzzy import formats
from leadscrew.fuzzy.system import System
from leadscrew.util.errors import DataError, NameUnknown, ValueRefused
from tests.fuzzy.formats_systems import systems
from tests.fuzzy.test_formats_broken import WHOLE

SOON = timedelta(seconds=5)
PIECES = re.compile(r"\w+|\s+|[^\w\s]")


def read_or_refused(text: str, format: str, **options: bool) -> None:
    try:
        found = formats.loads(text, format, **options)
    except DataError as error:
        assert re.match(r"text(:\d+:\d+)?: ", str(error))
    except (ValueRefused, NameUnknown):
        pytest.fail("a refusal without a place")
    else:
        assert isinstance(found, System)


@st.composite
def mutated(draw, text: str) -> str:
    pieces = PIECES.findall(text)
    for _ in range(draw(st.integers(1, 6))):
        if not pieces:
            break
        at, other = (draw(st.integers(0, len(pieces) - 1)) for _ in range(2))
        how = draw(st.sampled_from(("drop", "twice", "swap", "cut", "other", "number", "junk")))
        if how == "drop":
            del pieces[at]
        elif how == "twice":
            pieces.insert(at, pieces[other])
        elif how == "swap":
            pieces[at], pieces[other] = pieces[other], pieces[at]
        elif how == "cut":
            del pieces[at : max(at + 1, min(other, at + 40))]
        elif how == "other":
            pieces[at] = pieces[other]
        elif how == "number":
            pieces[at] = draw(
                st.sampled_from(("-1", "1e999", "nan", "-inf", "0", "99999999999999999999", "1.5", "٣", "1_0"))
            )
        else:
            pieces[at] = draw(st.text(max_size=4))
    return "".join(pieces)


@pytest.mark.slow
@pytest.mark.parametrize("format", formats.READ)
@given(st.data())
@settings(max_examples=250, deadline=SOON, suppress_health_check=list(HealthCheck))
def test_a_mutated_file_is_read_or_refused(format, data):
    text = WHOLE[format]
    if format in formats.WRITTEN and data.draw(st.booleans()):
        text = formats.dumps(data.draw(systems(format)), format)
    read_or_refused(data.draw(mutated(text)), format)


@pytest.mark.slow
@pytest.mark.parametrize("format", ["fll", "fcl", "fml"])
@given(st.data())
@settings(max_examples=100, deadline=SOON, suppress_health_check=list(HealthCheck))
def test_a_mutated_file_whose_unknown_rules_are_left_out_is_read_or_refused(format, data):
    read_or_refused(data.draw(mutated(WHOLE[format])), format, leave_out_unknown=True)


@pytest.mark.parametrize("format", formats.READ)
@given(text=st.text(max_size=200))
@settings(max_examples=100, deadline=SOON)
def test_any_text_is_read_or_refused(format, text):
    read_or_refused(text, format)


LONG = 100_000
HOSTILE = {
    "quotes": "'" * LONG,
    "spaces": "'" + " " * LONG + "'",
    "comment signs": " %" * LONG + "'",
    "parentheses": "(" * LONG,
    "nots": "not " * LONG,
    "colons": "a:" * LONG,
    "digits": "1" * LONG,
    "lines": "\n" * LONG,
    "stars": "(*" * LONG,
}


@pytest.mark.slow
@pytest.mark.parametrize("what", HOSTILE)
@pytest.mark.parametrize("format", formats.READ)
def test_the_work_on_long_nonsense_does_not_grow_with_the_square_of_its_length(format, what):
    """In each place of a file where a value can stand."""
    starts = {
        "fis": ("'trimf',[0 0 1]", "'trimf'", "1, 1 (1) : 1", "[0 1]", "'s'"),
        "fll": ("x is a", "0.0 1.0", "a Triangle", "r\n"),
        "fcl": ("x IS a", "(0, 0)", "REAL", "RULE 1"),
        "fml": ("<term>", 'name="s"', "<rule "),
    }

    def seconds(place: str, nonsense: str) -> float:
        gc.disable()  # it would go through all that other tests have left
        start = time.process_time()
        try:
            read_or_refused(WHOLE[format].replace(place, nonsense, 1), format)
            return time.process_time() - start
        finally:
            gc.enable()

    def grows_with_the_square(place: str) -> bool:
        """Eight times the length: eight times the work, or 64 times; a second is more than any of them takes."""
        long, short = HOSTILE[what], HOSTILE[what][: len(HOSTILE[what]) // 8]
        return seconds(place, long) > 1.0 + 30.0 * seconds(place, short)

    for place in starts[format]:
        assert not all(grows_with_the_square(place) for _ in range(3)), place
