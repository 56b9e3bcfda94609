"""The waveform of a music file: how loud it is in each two hundredth of a second, for pictures of it."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.control.audio.music_file import MAX_DURATION, MusicFileError

PEAKS_PER_SECOND: Final = 200
BLOCK_SECONDS: Final = 4
"""Sound that is kept while the file is decoded [s]."""


def read_waveform(path: Path, on_block: Callable[[], None] = lambda: None) -> npt.NDArray[np.uint8]:
    """Return the largest deviation of each two hundredth of a second, (n,), 255 at full scale.

    The file is decoded in blocks, so that its length needs no memory. `on_block` is called after each of them; what it
    raises ends the work. MusicFileError if it cannot be read as music.
    """
    import av  # not at the top: it loads FFmpeg (0.2 s)
    from av.audio.resampler import AudioResampler

    found: list[npt.NDArray[np.uint8]] = []
    try:
        with av.open(str(path)) as container:
            if not container.streams.audio:
                raise MusicFileError(f"{path} holds no sound; name a file with a sound stream")
            stream = container.streams.audio[0]
            rate = max(int(stream.rate) // PEAKS_PER_SECOND, 1) * PEAKS_PER_SECOND  # a whole number for each peak
            resampler = AudioResampler(format="flt", layout="mono", rate=rate)
            hop, most = rate // PEAKS_PER_SECOND, rate * BLOCK_SECONDS
            kept, count = list[npt.NDArray[np.float32]](), 0

            def reduce(whole: bool) -> None:
                nonlocal kept, count
                samples = np.concatenate(kept) if kept else np.zeros(0, np.float32)
                if whole:
                    samples = np.pad(samples, (0, -len(samples) % hop))
                end = len(samples) // hop * hop
                blocks = np.nan_to_num(samples[:end], nan=0.0, posinf=0.0, neginf=0.0).reshape(-1, hop)
                peaks = np.maximum(blocks.max(axis=1, initial=0.0), -blocks.min(axis=1, initial=0.0))
                found.append(np.minimum(np.rint(peaks * 255.0), 255.0).astype(np.uint8))
                kept, count = [samples[end:]], len(samples) - end
                on_block()

            def keep(frame: Any) -> None:
                nonlocal count
                for part in resampler.resample(frame):
                    kept.append(part.to_ndarray().reshape(-1).astype(np.float32, copy=False))
                    count += len(kept[-1])

            for frame in container.decode(stream):
                keep(frame)
                if count >= most:
                    reduce(whole=False)
                    if len(found) * BLOCK_SECONDS > MAX_DURATION:
                        raise MusicFileError(f"{path} is longer than {MAX_DURATION / 3600:g} hours; cut it into pieces")
            keep(None)
            reduce(whole=True)
    except av.FFmpegError as error:
        raise MusicFileError(f"{path} cannot be read as music ({error.strerror or type(error).__name__})") from None
    except OSError as error:
        raise MusicFileError(f"{path} cannot be opened ({error.strerror or error})") from None
    return np.concatenate(found)
