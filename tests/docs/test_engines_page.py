"""The page on engines names the number of compiled modules that are kept."""

from leadscrew.kernel.cache import LIMIT
from tests.docs.snippets import ROOT


def test_the_page_names_as_many_kept_modules_as_the_cache_keeps():
    assert f"The {LIMIT} newest are kept." in (ROOT / "docs" / "engines.md").read_text(encoding="utf-8")
