"""The list of words: a private term that returns to a message, a page or a public name is noticed."""

import pytest

from tests.words import _in, bad, names, phrases


def test_no_text_and_no_public_name_has_a_word_of_the_list():
    assert [*phrases(), *names()] == []


@pytest.mark.parametrize("text", ["it is not told by this log", "Whose axis the file names.", "the axis stands still"])
def test_a_word_of_the_list_is_noticed(text):
    assert len(list(_in(text, "here"))) == 1


def test_a_name_that_does_not_say_what_a_value_is_is_noticed():
    assert bad("least_depth") and bad("servo.most") and not bad("held_out") and not bad("at_least")
