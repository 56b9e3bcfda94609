"""Tests of films as folders of images."""

import os
import wave
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from live.render.film.film_writer import FilmError
from live.render.film.image_sequence import ImageSequenceWriter
from live.render.film.streams import FilmSound

SIZE = (37, 23)


def noise(number: int, channels: int = 4) -> np.ndarray:
    """A picture of random pixels, bottom row first in memory as read from the GPU."""
    return np.random.default_rng(number).integers(0, 255, (SIZE[1], SIZE[0], channels), np.uint8)[::-1]


@pytest.mark.parametrize("channels", [3, 4])
def test_every_picture_is_written_losslessly(tmp_path: Path, channels: int) -> None:
    with ImageSequenceWriter(tmp_path / "take" / "a-%04d.png", size=SIZE, fps=25, alpha=channels == 4) as film:
        for number in range(9):
            picture = noise(number, channels)
            film.write(picture)
            picture[:] = 0  # it was copied
    names = sorted(path.name for path in (tmp_path / "take").iterdir())
    assert names == [f"a-{number:04d}.png" for number in range(9)]
    for number, name in enumerate(names):
        with Image.open(tmp_path / "take" / name) as image:
            assert image.mode == ("RGBA" if channels == 4 else "RGB")
            assert np.array_equal(np.asarray(image), noise(number, channels))
            assert image.info["srgb"] == 0


def test_sound_file_has_same_length_as_pictures(tmp_path: Path) -> None:
    music = np.linspace(-0.9, 0.9, 2000, dtype=np.float32)
    with ImageSequenceWriter(
        tmp_path / "%05d.png", size=SIZE, fps=30000 / 1001, sound=FilmSound.from_samples(music, 8000), alpha=True
    ) as film:
        for _ in range(10):
            film.write(noise(0))
    with wave.open(str(tmp_path / "sound.wav")) as sound:
        assert (sound.getnchannels(), sound.getframerate()) == (1, 8000)
        heard = np.frombuffer(sound.readframes(-1), "<i2") / 32767.0
    assert len(heard) == round(10 * 1001 / 30000 * 8000)
    assert np.abs(heard[:2000] - music).max() < 1e-4
    assert not heard[2000:].any()


def test_invalid_path_and_picture_shape_are_refused(tmp_path: Path) -> None:
    with pytest.raises(FilmError, match="No such file"):
        ImageSequenceWriter(tmp_path / "none" / "deeper" / "%05d.png", size=SIZE, fps=25)
    film = ImageSequenceWriter(tmp_path / "%05d.png", size=SIZE, fps=25, alpha=True)
    with pytest.raises(ValueError, match=r"\(23, 37, 4\)"):
        film.write(noise(0, 3))
    film.close()
    film.close()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="/dev/full, a disk that is always full, is of Linux")
def test_full_disk_is_reported_once(tmp_path: Path) -> None:
    for number in range(40):
        os.symlink("/dev/full", tmp_path / f"{number}.png")
    film = ImageSequenceWriter(tmp_path / "%d.png", size=SIZE, fps=25, alpha=True)

    def write_on() -> None:
        for number in range(30):
            film.write(noise(number))

    with pytest.raises(FilmError, match="No space left"):
        write_on()
    film.write(noise(0))
    film.close()
