"""Music files: decoding into memory, and offline analysis."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.clock.tracking.aubio_tracker import RATE_MAX_HZ, RATE_MIN_HZ
from live.control.audio.analysis import AudioAnalysis, MakeAnalysis
from live.control.events.events import ControlEvent, One

MAX_DURATION: Final = 3.0 * 3600.0
"""Maximum duration [s]; music is kept in memory, 21 MB per minute in stereo."""

MIN_DURATION: Final = 0.1

DOWNBEAT_LEAD: Final = 30.0
"""Lead time of a known first downbeat [s].

It is announced early so that a score that starts with it is not late, and no tracker moves the measure lines before it.
"""


_TEMPO_IN_NAME: Final = re.compile(
    r"(?<![0-9.])([0-9]{2,3}(?:\.[0-9]+)?)[ _-]?bpm|bpm[ _-]?([0-9]{2,3})(?![0-9])", re.I
)
TEMPO_MIN, TEMPO_MAX = 40.0, 240.0


def tempo_in_name(name: str) -> float | None:
    """Return the tempo in the name of a song, such as "Waltz 90 bpm" [bpm]; None if it has none from 40 to 240."""
    found = _TEMPO_IN_NAME.search(name)
    tempo = 0.0 if found is None else float(found[1] or found[2])
    return tempo if TEMPO_MIN <= tempo <= TEMPO_MAX else None


class MusicFileError(ValueError):
    """A file that cannot be played; the message states the file, the problem and the remedy."""


@dataclass(frozen=True, slots=True, eq=False)
class Music:
    """Decoded sound: `samples` (n, channels) with 1 or 2 channels, full scale = 1, at `sample_rate` [Hz]."""

    samples: npt.NDArray[np.float32]
    sample_rate: int

    @property
    def duration(self) -> float:
        """Duration [s]."""
        return float(self.samples.shape[0] / self.sample_rate)

    def block(self, start: int, count: int) -> npt.NDArray[np.float32]:
        """Return `count` frames from `start` on, shape (count, channels); music begins again at its end."""
        length = self.samples.shape[0]
        start %= length
        if start + count <= length:
            return self.samples[start : start + count]
        return np.take(self.samples, range(start, start + count), axis=0, mode="wrap")


def read_music(path: Path | str) -> Music:
    """Decode the first audio stream of any file that FFmpeg reads; more than two channels are mixed to stereo.

    Raises MusicFileError for a file that is missing, no music, without sound, or longer than three hours.
    """
    import av  # not at the top: it loads FFmpeg (0.2 s), which live input does not need

    path = Path(path)
    if path.is_dir():
        raise MusicFileError(f"{path} is a folder; name a music file (wav, flac, ogg, mp3, m4a …)")
    if not path.exists():
        raise MusicFileError(f"{path}: there is no such file; name a music file (wav, flac, ogg, mp3, m4a …)")
    try:
        with av.open(str(path)) as container:
            if not container.streams.audio:
                raise MusicFileError(f"{path} holds no sound; name a file with a sound stream")
            music = _decode(container, path)
    except av.FFmpegError as error:
        reason = error.strerror or type(error).__name__
        raise MusicFileError(
            f"{path} cannot be read as music ({reason}); is it complete? wav, flac, ogg, mp3 and m4a are understood"
        ) from None
    except OSError as error:
        raise MusicFileError(f"{path} cannot be opened ({error.strerror or error})") from None
    if music.duration < MIN_DURATION:
        raise MusicFileError(f"{path} holds {music.duration:.2f} s of sound; at least {MIN_DURATION} s are needed")
    return music


def _decode(container: Any, path: Path) -> Music:
    from av.audio.resampler import AudioResampler

    stream = container.streams.audio[0]
    told = float(container.duration or 0) / 1e6
    if told > MAX_DURATION:
        raise _too_long(path)
    rate, channels = int(stream.rate), min(int(stream.channels), 2)
    if not RATE_MIN_HZ <= rate <= RATE_MAX_HZ:
        raise MusicFileError(
            f"{path} has a sample rate of {rate} Hz; {RATE_MIN_HZ:g} to {RATE_MAX_HZ:g} Hz can be followed"
        )
    layout = "stereo" if channels == 2 else "mono"
    # blocks of a second: short ones take twice as long
    resampler = AudioResampler(format="flt", layout=layout, rate=rate, frame_size=rate)
    blocks: list[npt.NDArray[np.float32]] = []
    frames = 0

    def keep(decoded: Any) -> None:
        nonlocal frames
        for part in resampler.resample(decoded):
            block = part.to_ndarray().reshape(-1, channels).astype(np.float32, copy=False)
            blocks.append(block)
            frames += block.shape[0]
        if frames > MAX_DURATION * rate:
            raise _too_long(path)

    for frame in container.decode(stream):
        keep(frame)
    keep(None)
    samples = np.concatenate(blocks) if blocks else np.zeros((0, channels), np.float32)
    np.nan_to_num(samples, copy=False, nan=0.0, posinf=0.0, neginf=0.0)
    samples.setflags(write=False)
    return Music(samples, rate)


def _too_long(path: Path) -> MusicFileError:
    return MusicFileError(f"{path} is longer than {MAX_DURATION / 3600:g} hours; cut it into pieces")


class OfflineMusic:
    """Analyses music without playing it: returns the events that a player would have sent by a given time of the show.

    The first sample is heard at `begin` [s]. The events depend only on the music, not on the intervals of the calls.
    """

    def __init__(
        self,
        music: Music,
        *,
        begin: float = 0.0,
        one_at: float | None = None,
        analysis: MakeAnalysis = AudioAnalysis,
    ) -> None:
        """`one_at` [s of the music]: the first downbeat, if known; it is announced as One, DOWNBEAT_LEAD
        seconds before."""
        self._music = music
        self._begin = begin
        self._one = None if one_at is None else One(time=begin + one_at, source="audio")
        self._downbeat_frame = 0 if one_at is None else max(int((one_at - DOWNBEAT_LEAD) * music.sample_rate), 0)
        self._fed = 0
        self._analysis = analysis(music.sample_rate)
        if one_at is not None:
            self._analysis.set_downbeat(one_at)

    def events_until(self, time: float) -> list[ControlEvent]:
        """Return the events from the last call up to `time` [s], in order."""
        events: list[ControlEvent] = []
        wanted = int((time - self._begin) * self._music.sample_rate)
        if wanted >= 0:
            self._announce_downbeat(events)
        while self._fed < wanted:
            before = wanted if self._one is None else self._downbeat_frame
            block = self._music.block(self._fed, min(wanted - self._fed, before - self._fed, 65536))
            self._fed += block.shape[0]
            events += self._analysis.feed(block, self._time_of)
            self._announce_downbeat(events)
        return events

    def _announce_downbeat(self, events: list[ControlEvent]) -> None:
        if self._one is not None and self._fed >= self._downbeat_frame:
            events.append(self._one)
            self._one = None

    def _time_of(self, position: float) -> float:
        return self._begin + position
