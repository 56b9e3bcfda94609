"""Tests of the film writer: films are written and decoded again."""

import contextlib
import shutil
import threading
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from time import monotonic
from typing import Any

import av
import numpy as np
import pytest

from live.render.film.film_writer import FilmError, FilmWriter, Picture
from live.render.film.streams import FilmSound, Samples
from tests.fixtures.mostly_long import mostly_long

SIZE = (96, 64)


def grey_picture(level: int) -> Picture:
    """A grey picture."""
    return np.full((SIZE[1], SIZE[0], 3), level, np.uint8)


def open_film(path: Path) -> Any:
    """The film, opened for reading."""
    return av.open(str(path))


def decode(path: Path) -> tuple[list[Picture], Any]:
    """Pictures of a film as RGB, and a description of its video stream."""
    with open_film(path) as container:
        stream = container.streams.video[0]
        pictures = [frame.to_ndarray(format="rgb24") for frame in container.decode(stream)]
        told = {"rate": stream.average_rate, "size": (stream.width, stream.height), "codec": stream.codec.name}
        told["duration"] = stream.duration * stream.time_base
        told["pixels"] = stream.pix_fmt
    return pictures, told


def picture_times(path: Path) -> list[Fraction]:
    """Presentation time of each picture [s]."""
    with open_film(path) as container:
        return [frame.pts * frame.time_base for frame in container.decode(video=0)]


def decode_sound(path: Path) -> tuple[Samples, int]:
    """The sound of a film, shape (n, channels), and its rate [Hz]."""
    with open_film(path) as container:
        rate = container.streams.audio[0].rate
        pieces = [frame.to_ndarray() for frame in container.decode(audio=0)]
    return np.concatenate(pieces, axis=1).T, rate


def wait_for(condition: Callable[[], bool]) -> None:
    deadline = monotonic() + 60.0
    event = threading.Event()
    while not condition():
        assert monotonic() < deadline
        event.wait(0.005)


@pytest.mark.parametrize("fps", [25, 60, Fraction(30000, 1001)])
def test_every_picture_is_written_once_at_constant_rate(tmp_path: Path, fps: Fraction) -> None:
    path = tmp_path / "film.mp4"
    with FilmWriter(path, size=SIZE, fps=fps) as film:
        for number in range(40):
            film.write(grey_picture(5 * number + 20))
    pictures, told = decode(path)
    assert [round(float(picture.mean())) for picture in pictures] == pytest.approx(range(20, 220, 5), abs=2)
    assert told == {"rate": fps, "size": SIZE, "codec": "h264", "duration": 40 / Fraction(fps), "pixels": "yuv420p"}
    assert picture_times(path) == [number / Fraction(fps) for number in range(40)]
    assert (film.frames, film.dropped, film.notes) == (40, 0, ())


def test_colours_and_orientation_are_kept(tmp_path: Path) -> None:
    path = tmp_path / "film.mp4"
    picture = np.zeros((SIZE[1], SIZE[0], 3), np.uint8)
    patches = {
        (0, 0): (220, 30, 40), (0, 48): (30, 200, 60), (32, 0): (40, 60, 230), (32, 48): (240, 240, 235),
    }  # fmt: skip
    for (row, column), colour in patches.items():
        picture[row : row + 32, column : column + 48] = colour
    flipped = np.ascontiguousarray(picture[::-1])[::-1]  # a view upside down, as it comes back from the card
    with FilmWriter(path, size=SIZE, fps=30) as film:
        for _ in range(5):
            film.write(flipped)
    with open_film(path) as container:
        stream = container.streams.video[0]
        assert stream.codec_context.colorspace == 1, "told as BT.709, as players assume of films in high definition"
        planes = next(iter(container.decode(stream))).to_ndarray().astype(float)
    luma = planes[: SIZE[1]]
    for (row, column), (red, green, blue) in patches.items():
        # BT.709, limited range: Y' = 16 + 219 (0.2126 R' + 0.7152 G' + 0.0722 B')
        expected = 16 + 219 * (0.2126 * red + 0.7152 * green + 0.0722 * blue) / 255
        assert luma[row + 8 : row + 24, column + 8 : column + 40].mean() == pytest.approx(expected, abs=2.5)
    decoded = decode(path)[0][-1].astype(float)
    for (row, column), colour in patches.items():
        part = decoded[row + 8 : row + 24, column + 8 : column + 40].mean(axis=(0, 1))
        assert part == pytest.approx(colour, abs=12)


def tone(rate: int, seconds: float, channels: int = 2) -> Samples:
    """A sine of 440 Hz on the left, of 880 Hz on the right."""
    time = np.arange(round(rate * seconds)) / rate
    both = np.stack([0.5 * np.sin(2 * np.pi * 440 * time), 0.5 * np.sin(2 * np.pi * 880 * time)], axis=1)
    return both[:, :channels].astype(np.float32)


def pitch(samples: Samples, rate: int) -> float:
    """The strongest frequency [Hz]."""
    spectrum = np.abs(np.fft.rfft(samples * np.hanning(len(samples))))
    return float(np.argmax(spectrum) * rate / len(samples))


@pytest.mark.parametrize("live", [False, True])
@mostly_long(("rate", "channels", "out"), [(48000, 2, 48000), (44100, 1, 44100), (37800, 2, 48000)], quick=[1])
def test_sound_has_same_length_as_picture(tmp_path: Path, rate: int, channels: int, out: int, live: bool) -> None:
    path = tmp_path / "film.mp4"
    music = tone(rate, 5.0, channels)
    sound = FilmSound.from_samples(music, rate)
    with FilmWriter(path, size=SIZE, fps=30, sound=sound, live=live, depth=50) as film:
        for number in range(50):
            film.write(grey_picture(number))
    assert film.dropped == 0
    assert picture_times(path) == [Fraction(number, 30) for number in range(50)]
    heard, heard_rate = decode_sound(path)
    assert heard_rate == out
    assert heard.shape[1] == channels
    with open_film(path) as container:
        stream = container.streams.audio[0]
        assert float(stream.duration * stream.time_base) == pytest.approx(50 / 30, abs=1024 / out)
        assert container.streams.video[0].duration * container.streams.video[0].time_base == Fraction(50, 30)
    middle = heard[out // 4 : out]
    assert [pitch(middle[:, channel], out) for channel in range(channels)] == pytest.approx(
        [440, 880][:channels], abs=3
    )


def test_sound_and_picture_are_in_sync(tmp_path: Path) -> None:
    path = tmp_path / "film.mp4"
    rate = 48000
    music = np.zeros((2 * rate, 1), np.float32)
    music[rate : rate + 480, 0] = tone(rate, 0.01, 1)[:, 0]  # a click one second into the music
    with FilmWriter(path, size=SIZE, fps=50, sound=FilmSound.from_samples(music, rate, start=0.5)) as film:
        for _ in range(60):
            film.write(grey_picture(100))
    heard, _ = decode_sound(path)
    with open_film(path) as container:
        first = next(iter(container.decode(audio=0)))
        begin = float(first.pts * first.time_base)
    onset = begin + np.argmax(np.abs(heard[:, 0]) > 0.2) / rate
    assert onset == pytest.approx(0.5, abs=0.003)


def test_short_music_ends_or_loops() -> None:
    music = (np.arange(1, 11)[:, None] / 10).astype(np.float32)
    once, looped = FilmSound.from_samples(music, 10), FilmSound.from_samples(music, 10, loop=True)
    assert once.read(8, 5)[:, 0] == pytest.approx([0.9, 1.0, 0.0, 0.0, 0.0])
    assert looped.read(8, 5)[:, 0] == pytest.approx([0.9, 1.0, 0.1, 0.2, 0.3])
    assert looped.read(1_000_000_008, 3)[:, 0] == pytest.approx([0.9, 1.0, 0.1])
    late = FilmSound.from_samples(music, 10, start=-0.2)
    assert late.read(0, 4)[:, 0] == pytest.approx([0.0, 0.0, 0.1, 0.2])
    assert FilmSound.from_samples(np.zeros((0, 2), np.float32), 10, loop=True).read(3, 2).tolist() == [[0, 0], [0, 0]]
    assert FilmSound.from_samples(np.zeros((5, 6), np.float32), 10).channels == 2
    with pytest.raises(ValueError, match="shape"):
        FilmSound.from_samples(np.zeros((2, 2, 2), np.float32), 10)


def test_live_sound_may_be_late_and_invalid(tmp_path: Path) -> None:
    path = tmp_path / "film.mp4"
    asked: list[tuple[int, int]] = []

    def lagging(first: int, count: int) -> Samples:
        asked.append((first, count))
        piece = np.full((max(0, count - 1000), 2), 0.25, np.float32)
        piece[::7] = np.nan
        piece[::11] = 1e30
        return piece

    with FilmWriter(path, size=SIZE, fps=30, sound=FilmSound(48000, 2, lagging), live=True) as film:
        for _ in range(30):
            film.write(grey_picture(50))
            wait_for(lambda: film.dropped > 0 or len(asked) >= film.frames)
    assert film.dropped == 0
    firsts = [first for first, _ in asked]
    assert firsts == sorted(firsts)
    assert asked[0] == (0, 1600)
    assert asked[1] == (600, 2600), "what was missing is asked for again"
    with open_film(path) as container:
        stream = container.streams.audio[0]
        assert float(stream.duration * stream.time_base) == pytest.approx(1.0, abs=0.03)


def test_busy_encoder_drops_live_pictures_without_blocking(tmp_path: Path) -> None:
    path = tmp_path / "film.mp4"
    gate = threading.Event()

    def blocked(first: int, count: int) -> Samples:
        assert gate.wait(10.0)
        return np.zeros((count, 1), np.float32)

    film = FilmWriter(path, size=SIZE, fps=25, sound=FilmSound(48000, 1, blocked), live=True, depth=3)
    for number in range(20):  # none of these calls waits: the gate is opened only after them
        film.write(grey_picture(10 * number + 10))
    assert film.frames == 20
    assert film.dropped == 17, "one in work and two waiting"
    gate.set()
    wait_for(lambda: not film._free.empty())
    film.write(grey_picture(250))
    film.close()
    pictures, told = decode(path)
    assert told["duration"] == Fraction(21, 25)
    levels = [round(float(picture.mean())) for picture in pictures]
    assert levels == pytest.approx([10, 20] + [30] * 18 + [250], abs=3)
    assert (film.frames, film.dropped) == (21, 17)


def test_pictures_dropped_at_end_still_count_as_duration(tmp_path: Path) -> None:
    path = tmp_path / "film.mp4"
    gate = threading.Event()

    def blocked(first: int, count: int) -> Samples:
        assert gate.wait(10.0)
        return np.zeros((count, 1), np.float32)

    film = FilmWriter(path, size=SIZE, fps=25, sound=FilmSound(48000, 1, blocked), live=True, depth=2)
    for _ in range(10):
        film.write(grey_picture(80))
    gate.set()
    film.close()
    assert len(decode(path)[0]) == 10


def test_offline_film_waits_and_drops_nothing(tmp_path: Path) -> None:
    path = tmp_path / "film.mp4"
    with FilmWriter(path, size=SIZE, fps=25, depth=1) as film:
        for number in range(30):
            film.write(grey_picture(8 * number))
    assert len(decode(path)[0]) == 30
    assert film.dropped == 0


def test_unfinished_live_film_is_playable(tmp_path: Path) -> None:
    path, copy = tmp_path / "film.mp4", tmp_path / "torn.mp4"
    rng = np.random.default_rng(3)
    noise = rng.integers(0, 255, (8, SIZE[1], SIZE[0], 3), np.uint8)
    film = FilmWriter(path, size=SIZE, fps=10, live=True)
    for number in range(100):
        wait_for(lambda: not film._free.empty())
        film.write(noise[number % 8])
    wait_for(lambda: path.stat().st_size > 100_000)
    shutil.copy(path, copy)  # the power fails here
    film.close()
    shown = 0
    with open_film(copy) as container, contextlib.suppress(av.error.InvalidDataError):  # the last picture is half a one
        for _ in container.decode(video=0):
            shown += 1
    assert shown >= 20
    assert len(decode(path)[0]) == 100


def test_finished_film_has_index_before_data(tmp_path: Path) -> None:
    path = tmp_path / "film.mp4"
    with FilmWriter(path, size=SIZE, fps=25) as film:
        for _ in range(5):
            film.write(grey_picture(9))
    data = path.read_bytes()
    assert 0 < data.index(b"moov") < data.index(b"mdat")


@pytest.mark.parametrize(("size", "even"), [((97, 64), (96, 64)), ((96, 63), (96, 62)), ((33, 35), (32, 34))])
def test_odd_size_is_cropped_with_note(tmp_path: Path, size: tuple[int, int], even: tuple[int, int]) -> None:
    path = tmp_path / "film.mp4"
    width, height = size
    picture = np.full((height, width, 3), 200, np.uint8)
    picture[even[1] :] = picture[:, even[0] :] = 0
    with FilmWriter(path, size=size, fps=25) as film:
        film.write(picture)
    assert len(film.notes) == 1
    assert f"{width}x{height} is odd; the film is {even[0]}x{even[1]}" in film.notes[0]
    pictures, told = decode(path)
    assert told["size"] == even
    assert pictures[0].min() > 190


def test_missing_folder_is_reported_at_once(tmp_path: Path) -> None:
    path = tmp_path / "nowhere" / "film.mp4"
    with pytest.raises(FilmError, match=r"nowhere/film\.mp4: the film cannot be written: No such file"):
        FilmWriter(path, size=SIZE, fps=25)


def test_folder_in_place_of_file_is_refused(tmp_path: Path) -> None:
    folder = tmp_path / "film.mp4"
    folder.mkdir()
    with pytest.raises(FilmError, match="Is a directory"):
        FilmWriter(folder, size=SIZE, fps=25)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="/dev/full, a disk that is always full, is of Linux")
def test_full_disk_is_reported_once_without_blocking(tmp_path: Path) -> None:
    path = tmp_path / "film.mp4"
    path.symlink_to("/dev/full")
    rng = np.random.default_rng(5)
    errors: list[str] = []

    def attempt(action: Callable[[], Any]) -> Any:
        try:
            return action()
        except FilmError as error:
            errors.append(str(error))
            return None

    film = attempt(lambda: FilmWriter(path, size=SIZE, fps=25, depth=2))
    if film is not None:  # the first bytes may still have found room in a buffer
        for _ in range(200):
            attempt(lambda: film.write(rng.integers(0, 255, (SIZE[1], SIZE[0], 3), np.uint8)))
        attempt(film.close)
    assert len(errors) == 1
    assert "film.mp4" in errors[0]
    assert "No space left" in errors[0]


def test_sound_failure_is_reported_once(tmp_path: Path) -> None:
    def broken(first: int, count: int) -> Samples:
        raise OSError("the sound card was pulled out")

    film = FilmWriter(tmp_path / "film.mp4", size=SIZE, fps=25, sound=FilmSound(48000, 1, broken), depth=1)

    def write_on() -> None:
        for _ in range(1000):
            film.write(grey_picture(1))

    with pytest.raises(FilmError, match=r"film\.mp4.*the sound card was pulled out"):
        write_on()
    film.write(grey_picture(2))
    film.close()


def test_first_error_is_raised(tmp_path: Path) -> None:
    def broken(first: int, count: int) -> Samples:
        raise OSError("no sound")

    def show() -> None:
        with FilmWriter(tmp_path / "film.mp4", size=SIZE, fps=25, sound=FilmSound(48000, 1, broken)) as film:
            film.write(grey_picture(1))
            raise KeyError("the show's own")

    with pytest.raises(KeyError, match="the show's own"):
        show()


def test_film_without_pictures_can_be_closed(tmp_path: Path) -> None:
    film = FilmWriter(tmp_path / "film.mp4", size=SIZE, fps=25, sound=FilmSound.from_samples(tone(48000, 1.0), 48000))
    film.close()
    assert not film._thread.is_alive()


def test_wrong_pictures_and_settings_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "film.mp4"
    with FilmWriter(path, size=SIZE, fps=25) as film:
        with pytest.raises(ValueError, match=r"\(64, 96, 3\), uint8 is needed"):
            film.write(np.zeros((64, 96, 4), np.uint8))
        with pytest.raises(ValueError, match="uint8 is needed"):
            film.write(np.zeros((64, 96, 3), np.float32))
        film.write(grey_picture(0))
        film.write(grey_picture(0)[::-1])
    with pytest.raises(ValueError, match="1 to 1000"):
        FilmWriter(path, size=SIZE, fps=0)
    with pytest.raises(ValueError, match="at least 2"):
        FilmWriter(path, size=(1, 64), fps=25)
