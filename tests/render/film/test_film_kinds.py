"""Tests of the film formats: each is written and decoded again, with alpha where supported."""

from pathlib import Path

import av
import numpy as np
import pytest

from live.render.film.container_formats import FORMATS
from live.render.film.film_writer import FilmError, FilmWriter
from live.render.film.streams import FilmSound
from tests.render.film.test_film import decode, open_film, tone

SIZE = (96, 64)


def colour_patches(alpha: bool) -> np.ndarray:
    """Large patches of colour, with opacity rising to the right."""
    picture = np.zeros((SIZE[1], SIZE[0], 4), np.uint8)
    picture[:32, :48, :3], picture[:32, 48:, :3] = (220, 40, 40), (40, 190, 60)
    picture[32:, :48, :3], picture[32:, 48:, :3] = (50, 60, 220), (230, 220, 210)
    picture[..., 3] = np.repeat(np.arange(0, 256, 51, dtype=np.uint8), 16)
    return picture if alpha else picture[..., :3].copy()


@pytest.mark.parametrize("alpha", [False, True])
@pytest.mark.parametrize(("ending", "codec", "off"), [(".mov", "prores", 4), (".mkv", "ffv1", 0)])
def test_decoded_pictures_match_written_pictures(
    tmp_path: Path, ending: str, codec: str, off: int, alpha: bool
) -> None:
    path = tmp_path / f"film{ending}"
    with FilmWriter(path, size=SIZE, fps=25, alpha=alpha) as film:
        for _ in range(3):
            film.write(colour_patches(alpha))
    with open_film(path) as container:
        stream = container.streams.video[0]
        assert stream.codec.name == codec
        assert stream.average_rate == 25
        frames = [frame.to_ndarray(format="rgba" if alpha else "rgb24") for frame in container.decode(stream)]
    assert len(frames) == 3
    errors = np.abs(frames[1].astype(int) - colour_patches(alpha))
    inner = np.ones(errors.shape, np.bool_)
    inner[28:36] = inner[:, 44:52] = False  # what is coded in blocks spreads a little from one patch to the next
    assert errors[inner].max() <= off
    if alpha:
        assert np.unique(frames[1][..., 3]).tolist() == list(range(0, 256, 51)) or off > 0


def test_prores_with_alpha_is_tagged_4444(tmp_path: Path) -> None:
    path = tmp_path / "film.mov"
    with FilmWriter(path, size=SIZE, fps=25, alpha=True) as film:
        film.write(colour_patches(True))
    with open_film(path) as container:
        context = container.streams.video[0].codec_context
        assert context.codec_tag == "ap4h"
        assert "yuva444p" in context.pix_fmt
        assert (context.colorspace, context.color_range) == (1, 1), "BT.709, limited range"


@pytest.mark.parametrize("ending", [".mov", ".mkv"])
def test_sound_is_stored_uncompressed(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"film{ending}"
    music = tone(44100, 3.0)
    with FilmWriter(path, size=SIZE, fps=30, sound=FilmSound.from_samples(music, 44100)) as film:
        for _ in range(45):
            film.write(colour_patches(False))
    with open_film(path) as container:
        assert container.streams.audio[0].codec.name == "pcm_s16le"
        pieces = [frame.to_ndarray().reshape(-1, 2) for frame in container.decode(audio=0)]
    heard = np.concatenate(pieces).astype(float) / 32768.0
    assert len(heard) == 66150
    assert np.abs(heard - music[:66150]).max() < 2 / 32768


def test_ntsc_frame_rate_is_exact(tmp_path: Path) -> None:
    path = tmp_path / "film.mov"
    with FilmWriter(path, size=SIZE, fps=60000 / 1001) as film:
        for _ in range(4):
            film.write(colour_patches(False))
    assert decode(path)[1]["rate"] * 1001 == 60000


def test_unsupported_formats_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"ends in \.mp4, \.mov, \.mkv"):
        FilmWriter(tmp_path / "film.avi", size=SIZE, fps=25)
    with pytest.raises(ValueError, match="no alpha"):
        FilmWriter(tmp_path / "film.mp4", size=SIZE, fps=25, alpha=True)
    with pytest.raises(FilmError, match="No such file"):
        FilmWriter(tmp_path / "none" / "film.mov", size=SIZE, fps=25)


def test_every_format_has_installed_codec() -> None:
    for kind in FORMATS.values():
        assert kind.video in av.codecs_available
        assert kind.container in av.formats_available
