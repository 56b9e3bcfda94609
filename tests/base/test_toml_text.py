"""TOML parsing with limits on numbers and dotted keys."""

import time
import tomllib

import pytest

from live.base.toml import MAX_DOTTED_KEYS, parse_toml


@pytest.mark.parametrize("value", ["9" * 5000, "0x" + "f" * 20, "0x" + "f" * 50000, "[1, [-9, 0b" + "1" * 70 + "]]"])
def test_endless_numbers_are_refused_with_their_line(value):
    with pytest.raises(tomllib.TOMLDecodeError, match=r"too many digits \(at line 3"):
        parse_toml(f"a = 1\n\nb = {value}\n")


def test_digits_in_strings_are_not_limited():
    text = f'name = "{"9" * 5000} 0x{"f" * 50}"\n'
    assert parse_toml(text) == tomllib.loads(text)
    assert parse_toml("seed = 0xffff_ffff_ffff_ffff\n") == {"seed": 2**64 - 1}


def test_endless_dotted_keys_are_refused_quickly():
    begin = time.perf_counter()
    for text in ("[" + ".".join("a" * 100_000) + "]", '"a b".' * 40_000 + "a = 1", "x = {" + "a . " * 40_000 + "}"):
        with pytest.raises(tomllib.TOMLDecodeError, match="keys joined by dots"):
            parse_toml(text)
    parse_toml(".".join("a" * MAX_DOTTED_KEYS) + " = 1")
    assert time.perf_counter() - begin < 2.0  # tomllib takes more than half a minute


def test_long_texts_without_dots_are_parsed():
    text = "x" * 200_000 + ' = "' + "y" * 200_000 + '"\nz = [' + "0.25, " * 50_000 + "]\n"
    assert parse_toml(text) == tomllib.loads(text)
