"""Parsing of film names and frame rates."""

from fractions import Fraction
from pathlib import Path

import pytest

from live.app.film.film_names import parse_film_path, parse_frames, parse_rate
from live.base.errors import PersonError


@pytest.mark.parametrize(
    ("text", "rate"),
    [
        ("60", 60), ("25", 25), ("29.97", Fraction(30000, 1001)), ("59.94", Fraction(60000, 1001)),
        ("23.976", Fraction(24000, 1001)), ("24000/1001", Fraction(24000, 1001)), ("12.5", Fraction(25, 2)),
        ("50.0", 50), (" 48 ", 48), ("119.88", Fraction(120000, 1001)),
    ],
)  # fmt: skip
def test_frame_rates_are_parsed(text: str, rate: Fraction) -> None:
    found = parse_rate(text)
    assert found is not None
    assert Fraction(found).limit_denominator(1001) == rate


@pytest.mark.parametrize("text", ["", "fast", "0", "-25", "481", "1/0", "nan", "inf", "25 30"])
def test_invalid_frame_rates_are_refused(text: str) -> None:
    with pytest.raises(PersonError, match="--fps"):
        parse_rate(text)
    assert parse_rate(None) is None


def test_film_paths_are_parsed(tmp_path: Path) -> None:
    for name in ("film.mp4", "film.mov", "FILM.MKV"):
        assert parse_film_path(tmp_path / name, "--out", inputs=[None]) == tmp_path / name
    assert parse_film_path(tmp_path, "--out", inputs=[]) == tmp_path / "%05d.png"
    assert parse_film_path(tmp_path / "take", "--out", alpha=True, inputs=[]) == tmp_path / "take" / "%05d.png"
    assert parse_film_path(tmp_path / "take" / "a%d.png", "--out", inputs=[]) == tmp_path / "take" / "a%d.png"


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("film.avi", "ends in"), ("film.png", "%05d"), ("a%d%d.png", "%05d"), ("a%s.png", "%05d"),
        ("100%-%05d.png", "%05d"),
        ("none/film.mp4", "no folder"), ("none/take/%05d.png", "no folder"), ("%d/%d.png", "not in the folder's"),
    ],
)  # fmt: skip
def test_invalid_film_paths_are_refused(tmp_path: Path, name: str, told: str) -> None:
    with pytest.raises(PersonError) as error:
        parse_film_path(tmp_path / name, "--out", inputs=[])
    assert told in str(error.value.message) + str(error.value.remedy)


def test_alpha_in_mp4_and_input_file_are_refused(tmp_path: Path) -> None:
    with pytest.raises(PersonError, match="no alpha") as error:
        parse_film_path(tmp_path / "film.mp4", "--out", alpha=True, inputs=[])
    assert "film.mov" in str(error.value.remedy)
    song = tmp_path / "song.mp4"
    song.write_bytes(b"")
    with pytest.raises(PersonError, match="the show reads this file"):
        parse_film_path(song, "--out", inputs=[str(song)])


def test_frames_are_half_open_and_from_0() -> None:
    assert parse_frames(None) is None
    assert parse_frames("0:240") == (0, 240)
    assert parse_frames(":7") == (0, 7)
    assert parse_frames(" 12: ") == (12, None)


@pytest.mark.parametrize("text", ["", "5", "7:7", "9:3", "-1:4", "1:2:3", "a:b", "1.5:3", "0x1:4"])
def test_frames_that_are_none_are_refused(text: str) -> None:
    with pytest.raises(PersonError, match="--frames"):
        parse_frames(text)
