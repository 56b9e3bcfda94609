"""Video pictures by time: every picture in a film, the newest available in a show, after seeks and damage too."""

import itertools

import pytest

from live.base.errors import PersonError
from live.render.media.media_files import Video, check_media, open_video
from tests.control.waiting import wait_for
from tests.render.media import FRAMES, RATE, grey_of, write_image, write_video


@pytest.fixture(scope="module")
def film(tmp_path_factory):
    return write_video(tmp_path_factory.mktemp("film") / "greys.mp4")


def picture_number(picture):
    """The number of a picture."""
    return round((float(picture.mean()) - grey_of(0)) / 10.0)


@pytest.mark.long
def test_blocking_video_returns_every_picture_once(film):
    video = Video(film, blocking=True)
    assert video.seconds == pytest.approx(FRAMES / RATE, abs=0.02)
    for number in range(FRAMES):
        assert picture_number(video.picture_at(number / RATE + 0.03)) == number
        assert video.picture_at(number / RATE + 0.06) is None  # the same still
    video.close()


def test_blocking_video_seeks_to_any_time(film):
    video = Video(film, blocking=True)
    for place in (15, 3, 19, 0, 8, 7, 18, 1):
        picture = video.picture_at(place / RATE + 0.05)
        assert picture_number(picture) == place
    video.close()


def test_nonblocking_video_returns_pictures_when_decoded(film):
    video = Video(film)
    assert wait_for(lambda: (picture := video.picture_at(0.55)) is not None and picture_number(picture) == 5, 5.0)
    video.close()


class DamagedContainer:
    """A container whose fourth picture cannot be decoded."""

    def __init__(self, container):
        self._container = container

    def __getattr__(self, name):
        return getattr(self._container, name)

    def decode(self, stream):
        yield from itertools.islice(self._container.decode(stream), 3)
        raise OSError("damaged")


def test_damaged_video_keeps_last_picture_and_reports_problem(film, monkeypatch):
    monkeypatch.setattr("live.render.media.media_files.open_video", lambda path: DamagedContainer(open_video(path)))
    video, got = Video(film), []
    assert wait_for(lambda: (got.append(video.picture_at(0.45)), video.problem == "damaged")[1], 5.0)
    last = [picture_number(picture) for picture in [*got, video.picture_at(0.45)] if picture is not None][-1]
    assert last == 2
    assert video.picture_at(0.9) is None
    video.close()


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("no.mp4", b"this is no video at all", "cannot be opened"),
        ("no.png", b"\x89PNG\r\n\x1a\nnor an image", "cannot be read"),
        ("notes.txt", b"words", "neither an image nor a video"),
    ],
)
def test_unreadable_background_is_refused_with_reason(tmp_path, name, content, words):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(PersonError, match=words):
        check_media(tmp_path / name)


def test_oversized_image_is_refused_before_decoding(tmp_path, monkeypatch):
    monkeypatch.setattr("live.render.media.media_files.MAX_PIXELS", 1000)
    with pytest.raises(PersonError, match="64 x 36 pixels"):
        check_media(write_image(tmp_path / "big.png"))
