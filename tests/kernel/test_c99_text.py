"""Texts in printed C, without a compiler."""

import pytest

from leadscrew.kernel.c99 import comments


@pytest.mark.parametrize(
    "text",
    ["*/", "*``/", "/*/", "**//*", "??/", "a ?``?/", "\u202eabc", "\x00\x1b", "*" * 9 + "/", "a\\\nb", "a\rb"],
)
@pytest.mark.parametrize("place", ["", "x.py:3"])
def test_nothing_that_a_user_writes_ends_a_comment_or_hides_what_follows(text, place):
    for lines in ([text], [text, text + text, ""]):
        comment = comments.block(lines, place)
        assert comment.startswith("/* ") and comment.endswith(" */\n")
        inner = comment[2:-3]
        # Trigraph ??/ is a backslash: at the end of a line it would join the next one.
        assert not any(mark in inner for mark in ("*/", "/*", "??/"))
        assert all(c.isprintable() or c == "\n" for c in inner)
        assert all(line.startswith(" *") for line in inner.splitlines()[1:])
