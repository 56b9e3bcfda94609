"""Tests of the phones' page: texts in all languages, one small file, nothing that its words could break."""

import gzip
import re

import pytest

from live.control.audience.http_server import LANGUAGES, WORDS, page_text

PAGE = page_text()


def entries(words, at=""):
    """All texts of a language with their places."""
    for key, value in words.items() if isinstance(words, dict) else enumerate(words):
        if isinstance(value, str):
            yield f"{at}/{key}", value
        else:
            yield from entries(value, f"{at}/{key}")


@pytest.mark.parametrize("language", LANGUAGES)
def test_each_language_has_all_texts_with_the_same_places_for_names_and_numbers(language):
    english, own = dict(entries(WORDS["en"])), dict(entries(WORDS[language]))
    assert own.keys() == english.keys()
    for key, text in own.items():
        assert set(re.findall(r"\{\w+\}", text)) == set(re.findall(r"\{\w+\}", english[key])), key
        assert text == text.strip()
        assert not set("<>\\\u2028\u2029") & set(text)
    if language != "en":
        same = [key for key, text in own.items() if text == english[key]]
        assert set(same) <= {"/theirs/1"}


def test_page_is_one_small_file():
    assert len(LANGUAGES) == 7
    assert len(gzip.compress(PAGE.encode(), 9)) < 17_000
    assert "/*words*/" not in PAGE
    assert "/*script*/" not in PAGE
    assert PAGE.count("<script>") == PAGE.count("</script>") == 1
    script = PAGE.partition("<script>")[2].partition("</script>")[0]
    assert "innerHTML" not in script  # names are put in as text
    assert "<" not in re.search(r"const WORDS = (.*);\n", script)[1]


def test_page_uses_every_text():
    script = PAGE.partition("const WORDS")[2].partition("\n")[2]
    for key in WORDS["en"]:
        by_state = key in ("link", "full", "address", "joins", "joining", "away")  # say[why]
        assert by_state or re.search(rf"\bsay\.{key}\b|\{{ {key} \}}", script), key
