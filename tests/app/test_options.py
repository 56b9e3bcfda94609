"""Shared options: parsing and refusals."""

import math

import pytest

from live.app.option_values import check_range, check_writable, parse_endpoint, parse_size
from live.base.errors import PersonError


@pytest.mark.parametrize(
    ("text", "size"), [("1280x720", (1280, 720)), (" 640 X 360 ", (640, 360)), ("16×16", (16, 16))]
)
def test_sizes_are_parsed(text, size):
    assert parse_size(text) == size


@pytest.mark.parametrize("text", ["", "1280", "0x720", "1280x", "99999x720", "axb", "-16x16", "9000x16"])
def test_invalid_sizes_are_refused(text):
    with pytest.raises(PersonError, match="width and height"):
        parse_size(text)


@pytest.mark.parametrize(
    ("text", "endpoint"),
    [
        ("127.0.0.1:9010", ("127.0.0.1", 9010)),
        ("9011", ("127.0.0.1", 9011)),
        ("localhost:0", ("localhost", 0)),
        ("[::1]:7000", ("::1", 7000)),
    ],
)
def test_endpoints_are_parsed(text, endpoint):
    assert parse_endpoint(text) == endpoint


@pytest.mark.parametrize("text", ["", "host", "host:", "host:70000", "a:b:1", "host:-1"])
def test_invalid_endpoints_are_refused(text):
    with pytest.raises(PersonError, match="HOST:PORT"):
        parse_endpoint(text)


@pytest.mark.parametrize("value", [math.nan, math.inf, 0.0, 1e9])
def test_numbers_out_of_range_are_refused(value):
    with pytest.raises(PersonError, match="20 to 400"):
        check_range(value, "--bpm", 20, 400)
    check_range(None, "--bpm", 20, 400)
    check_range(120.0, "--bpm", 20, 400)


def test_unwritable_files_are_refused(tmp_path):
    with pytest.raises(PersonError, match="no folder"):
        check_writable(tmp_path / "a" / "b.mp4", "--record")
    with pytest.raises(PersonError, match="that is a folder"):
        check_writable(tmp_path, "--record")
    check_writable(tmp_path / "b.mp4", "--record")
    check_writable(None, "--record")
