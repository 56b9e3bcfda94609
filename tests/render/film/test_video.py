"""Video pictures by time: every picture in a film, the newest available in a show, after seeks and damage too."""

import time

import av
import numpy as np
import pytest
from PIL import Image

from live.base.errors import PersonError
from live.render.media.media_files import (
    BLOCKING_TIMEOUT_S,
    ImageSequence,
    Video,
    check_media,
    read_image,
    sequence_files,
)
from tests.control.waiting import wait_for
from tests.render.media import FRAMES, RATE, grey_of, write_image, write_sequence, write_video


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


def damaged(path, begin, end):
    """The file with zeros in a part of it, given by shares of its length."""
    data = bytearray(path.read_bytes())
    first, last = round(begin * len(data)), round(end * len(data))
    data[first:last] = bytes(last - first)
    path.write_bytes(data)
    return path


def test_damaged_video_keeps_last_picture_and_goes_on_after_the_damage(tmp_path):
    video = Video(damaged(write_video(tmp_path / "v.avi", codec="png", noise=True), 0.4, 0.6), blocking=True)
    seen = [video.picture_at(number / RATE + 0.05) for number in range(FRAMES)]
    video.close()
    numbers = [None if picture is None else picture_number(picture) for picture in seen]
    assert numbers[:7] == list(range(7))
    assert None in numbers[7:]
    known = [number for number in numbers if number is not None]
    assert known == sorted(known)
    assert video.problem
    again = Video(tmp_path / "v.avi", blocking=True)  # whoever comes later sees what is whole
    assert picture_number(again.picture_at((FRAMES - 1) / RATE)) == FRAMES - 1
    again.close()


def test_video_that_breaks_off_holds_its_last_picture_without_waiting(tmp_path):
    path = write_video(tmp_path / "v.mkv", size=(320, 240), noise=True)
    data = path.read_bytes()
    path.write_bytes(data[: round(0.55 * len(data))])
    video = Video(path, blocking=True)
    begin = time.process_time(), time.monotonic()
    seen = [video.picture_at(number / RATE + 0.05) for number in range(FRAMES)]
    assert time.monotonic() - begin[1] < BLOCKING_TIMEOUT_S  # one picture would wait so long
    video.close()
    assert 5 < sum(picture is not None for picture in seen) < FRAMES - 4
    assert seen[-1] is None


def test_opacity_of_images_and_videos_is_kept(tmp_path):
    clear = np.zeros((8, 12, 4), np.uint8)
    clear[:, 6:] = 255, 128, 0, 200
    Image.fromarray(clear).save(tmp_path / "a.png")
    assert np.array_equal(read_image(tmp_path / "a.png"), clear)
    assert read_image(write_image(tmp_path / "b.png")).shape[2] == 3
    with av.open(str(tmp_path / "v.mov"), "w") as out:
        stream = out.add_stream("qtrle", rate=RATE)
        stream.width, stream.height, stream.pix_fmt = 12, 8, "argb"
        out.mux(stream.encode(av.VideoFrame.from_ndarray(clear, format="rgba").reformat(format="argb")))
        out.mux(stream.encode())
    video = Video(tmp_path / "v.mov", blocking=True)
    assert video.components == 4
    assert np.array_equal(video.picture_at(0.0), clear)
    video.close()


def test_image_sequence_has_its_order_keeps_gaps_and_leaves_out_damaged_images(tmp_path):
    folder = write_sequence(tmp_path / "rain", numbers=(7, 8, 10, 11))
    (folder / "pic_010.png").write_bytes(b"no image")
    (folder / "pic_9.png").write_bytes((folder / "pic_007.png").read_bytes())  # other digits: not of the sequence
    assert [number for number, _ in sequence_files(folder / "pic_###.png")] == [7, 8, 10, 11]
    sequence = ImageSequence(folder / "pic_###.png", 10.0, blocking=True)
    assert sequence.seconds == pytest.approx(0.5)
    seen = [sequence.picture_at(0.1 * number + 0.05) for number in range(5)]
    sequence.close()
    assert [None if each is None else picture_number(each) for each in seen] == [0, 1, None, None, 3]
    assert "pic_010.png" in sequence.problem
    with pytest.raises(PersonError, match="there is no image"):
        check_media(folder / "snow_##.png")


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
