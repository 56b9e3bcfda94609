"""Films that are encoded in parts and joined: the same pictures as films that are encoded in one go."""

import itertools
import wave
from fractions import Fraction

import av
import numpy as np
import pytest

from live.render.film.container_formats import FORMATS, segment_length
from live.render.film.film_parts import PartWriter, join_parts, write_sound
from live.render.film.film_writer import FilmError, FilmWriter
from live.render.film.streams import FilmSound
from tests.fixtures.mostly_long import mostly_long

SIZE, FPS = (64, 36), 10.0
SEGMENT = 20
FIRST, BOUNDS = 15, (15, 40, 60, 67)
"""The first part begins within a segment, as a film of some measures does."""


def picture(number):
    """Stripes that move, with some noise."""
    rows = np.arange(SIZE[1])[:, None, None]
    stripes = 120 + 80 * np.sin((rows + np.arange(SIZE[0])[None, :, None] + 3 * number) / 6.0)
    noise = np.random.default_rng(number).integers(0, 24, (SIZE[1], SIZE[0], 3))
    return (stripes + noise).astype(np.uint8)


def decoded(path):
    """Times and pictures of a film, and its sound."""
    with av.open(str(path)) as film:
        pictures = [(frame.time, frame.to_ndarray(format="rgb24").tobytes()) for frame in film.decode(video=0)]
    with av.open(str(path)) as film:
        return pictures, b"".join(frame.to_ndarray().tobytes() for frame in film.decode(audio=0))


def made_sound():
    """Nine seconds of a tone."""
    return FilmSound.from_samples(np.sin(np.arange(9 * 8000) / 9.0).astype(np.float32), 8000)


def made_parts(folder, film, **options):
    """Parts of the film in files, with their numbers of frames."""
    parts = []
    for number, (first, end) in enumerate(itertools.pairwise(BOUNDS)):
        part = folder / f"{number}.part"
        with PartWriter(part, film, size=SIZE, fps=FPS, first=first, **{"threads": 2, **options}) as writer:
            for frame in range(first, end):
                writer.write(picture(frame))
        parts.append((part, end - first))
    return parts


@mostly_long("ending", FORMATS, quick=[2])
def test_joined_film_equals_one_encoded_in_one_go(tmp_path, ending):
    assert segment_length(Fraction(10), FORMATS[ending]) == SEGMENT
    whole, joined = tmp_path / f"whole{ending}", tmp_path / f"joined{ending}"
    with FilmWriter(whole, size=SIZE, fps=FPS, sound=made_sound(), first=FIRST, threads=2) as film:
        for frame in range(BOUNDS[0], BOUNDS[-1]):
            film.write(picture(frame))
    join_parts(joined, made_parts(tmp_path, joined), size=SIZE, fps=FPS, sound=made_sound())
    pictures, sound = decoded(joined)
    assert [time for time, _ in pictures] == pytest.approx([frame / FPS for frame in range(BOUNDS[-1] - FIRST)])
    assert (pictures, sound) == decoded(whole)
    assert joined.stat().st_size == whole.stat().st_size


def test_picture_depends_on_no_other_segment(tmp_path):
    films = []
    for first in (15, 40):
        path = tmp_path / f"{first}.mp4"
        with FilmWriter(path, size=SIZE, fps=FPS, sound=made_sound(), first=first, threads=2) as film:
            for frame in range(first, 67):
                film.write(picture(frame))
        films.append([data for _, data in decoded(path)[0]])
    assert films[0][25:] == films[1]


def test_damaged_and_foreign_parts_are_refused(tmp_path):
    film = tmp_path / "film.mp4"
    parts = made_parts(tmp_path, film)
    data = parts[1][0].read_bytes()
    for bad, words in ((data[:-9], "damaged"), (data[: len(data) // 2] + b"\xff" * 9, "damaged|cut off")):
        parts[1][0].write_bytes(bad)
        with pytest.raises(FilmError, match=words):
            join_parts(film, parts, size=SIZE, fps=FPS, sound=None)
    ends = [0]
    while ends[-1] < len(data):  # of its records, each with its size before it
        ends.append(ends[-1] + 29 + int.from_bytes(data[ends[-1] + 25 : ends[-1] + 29], "little"))
    parts[1][0].write_bytes(data[: ends[-2]])
    with pytest.raises(FilmError, match="19 pictures instead of 20"):
        join_parts(film, parts, size=SIZE, fps=FPS, sound=None)
    other = made_parts(tmp_path, tmp_path / "film.mov")
    with pytest.raises(FilmError, match="another version of the encoder"):
        join_parts(film, other, size=SIZE, fps=FPS, sound=None)
    with pytest.raises(FilmError, match="cannot be written"):
        join_parts(tmp_path / "none" / "film.mp4", other, size=SIZE, fps=FPS, sound=None)


def test_sound_of_pictures_is_as_long_as_they_are(tmp_path):
    write_sound(tmp_path / "%05d.png", made_sound(), 33, 30000 / 1001)
    with wave.open(str(tmp_path / "sound.wav")) as sound:
        assert sound.getnframes() == round(33 * 1001 / 30000 * 8000)
