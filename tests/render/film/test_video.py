"""A video's pictures by their time: in a film every one, in a show whatever is there, after leaps and damage too."""

import itertools

import pytest

from live.base.errors import PersonError
from live.render.media_background import Video, check_background, open_video
from tests.control.waiting import wait_for
from tests.render.media import FRAMES, RATE, grey_of, write_image, write_video


@pytest.fixture(scope="module")
def film(tmp_path_factory):
    return write_video(tmp_path_factory.mktemp("film") / "greys.mp4")


def seen(picture):
    """The number of a picture."""
    return round((float(picture.mean()) - grey_of(0)) / 10.0)


@pytest.mark.long
def test_a_patient_video_gives_every_picture_at_its_time_and_none_twice(film):
    video = Video(film, blocking=True)
    assert video.seconds == pytest.approx(FRAMES / RATE, abs=0.02)
    for number in range(FRAMES):
        assert seen(video.picture_at(number / RATE + 0.03)) == number
        assert video.picture_at(number / RATE + 0.06) is None  # the same still
    video.close()


def test_a_patient_video_leaps_anywhere_and_begins_again(film):
    video = Video(film, blocking=True)
    for place in (15, 3, 19, 0, 8, 7, 18, 1):
        picture = video.picture_at(place / RATE + 0.05)
        assert seen(picture) == place
    video.close()


def test_a_show_never_waits_and_gets_pictures_as_they_come(film):
    video = Video(film)
    assert wait_for(lambda: (picture := video.picture_at(0.55)) is not None and seen(picture) == 5, 5.0)
    video.close()


class Damaged:
    """A container whose fourth picture cannot be decoded."""

    def __init__(self, container):
        self._container = container

    def __getattr__(self, name):
        return getattr(self._container, name)

    def decode(self, stream):
        yield from itertools.islice(self._container.decode(stream), 3)
        raise OSError("damaged")


def test_a_video_that_is_damaged_keeps_its_last_picture_and_says_why(film, monkeypatch):
    monkeypatch.setattr("live.render.media_background.open_video", lambda path: Damaged(open_video(path)))
    video, got = Video(film), []
    assert wait_for(lambda: (got.append(video.picture_at(0.45)), video.problem == "damaged")[1], 5.0)
    last = [seen(picture) for picture in [*got, video.picture_at(0.45)] if picture is not None][-1]
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
def test_files_that_cannot_be_shown_are_named(tmp_path, name, content, words):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(PersonError, match=words):
        check_background(tmp_path / name)


def test_an_image_of_a_giant_is_refused_before_it_is_unpacked(tmp_path, monkeypatch):
    monkeypatch.setattr("live.render.media_background.MAX_PIXELS", 1000)
    with pytest.raises(PersonError, match="64 x 36 pixels"):
        check_background(write_image(tmp_path / "big.png"))
