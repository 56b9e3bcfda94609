"""Features of whole recordings for the training: the same bands as the engine's, many frames at once, kept on disk.

Bands are kept before the running level and the compression, as natural logarithms in float16 (exact to 0.8 %), so
that loudness, tilt and noise can still be changed for each example.
"""

import json
import multiprocessing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
import numpy.typing as npt
import scipy.fft

from live.clock.tracking.features import (
    ANALYSIS_WINDOWS,
    BANDS_PER_WINDOW,
    BASE_HOP,
    BASE_RATE,
    HOP,
    filters,
    window_length,
)

LOG_FLOOR: Final = 1e-7
"""Added to magnitudes before the logarithm (-140 dB)."""

CHUNK: Final = 512
"""Frames that are transformed together."""


@dataclass(frozen=True, slots=True, eq=False)
class Item:
    """One recording, ready to be learned from."""

    name: str
    style: str
    log_bands: npt.NDArray[np.float16]
    """Natural logarithm of the band magnitudes, shape (frames, bands)."""
    beats: npt.NDArray[np.float64]
    """Times of the beats [s], shape (n,)."""
    places: npt.NDArray[np.int32]
    """Place of each beat in its measure, 1 = downbeat, 0 = unknown, shape (n,)."""
    facts: dict[str, Any]
    """What the maker of the recording wrote about it."""


def band_matrix(ear_index: int) -> npt.NDArray[np.float32]:
    """An ear's filters at 44.1 kHz as a matrix, shape (bins, bands)."""
    ear = ANALYSIS_WINDOWS[ear_index]
    length = window_length(ear, BASE_RATE)
    kept = filters(ear, BASE_RATE, length)
    matrix = np.zeros((length // 2 + 1, kept.start.size), np.float32)
    for band, start in enumerate(kept.start):
        weights = kept.weight[kept.offset[band] : kept.offset[band + 1]]
        matrix[start : start + weights.size, band] = weights
    return matrix


def bands_of(sound: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Band magnitudes of a recording (n,) at 44.1 kHz as the engine's Spectrum gives them, shape (frames, bands)."""
    frames = sound.shape[0] // BASE_HOP
    longest = max(ear.window for ear in ANALYSIS_WINDOWS)
    padded = np.concatenate([np.zeros(longest, np.float32), sound.astype(np.float32)])
    out = []
    for index, ear in enumerate(ANALYSIS_WINDOWS):
        matrix = band_matrix(index)
        window = np.hanning(ear.window + 1)[:-1].astype(np.float32)
        first = longest + BASE_HOP - ear.window
        cuts = np.lib.stride_tricks.sliding_window_view(padded[first:], ear.window)[::BASE_HOP][:frames]
        used = np.flatnonzero(matrix.any(axis=1))[-1] + 1
        rows = [
            np.abs(scipy.fft.rfft(cuts[start : start + CHUNK] * window, axis=1)[:, :used]) @ matrix[:used]
            for start in range(0, frames, CHUNK)
        ]
        out.append(np.concatenate(rows))
    return np.concatenate(out, axis=1)


def read_beats(path: Path) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int32]]:
    """(times [s] (n,), places in the measure (n,)) from lines "time place"; a missing place is 0."""
    times, places = [], []
    for line in path.read_text(encoding="utf-8").splitlines():
        words = line.split()
        if words and not line.startswith("#"):
            times.append(float(words[0]))
            places.append(int(float(words[1])) if len(words) > 1 else 0)
    return np.array(times), np.array(places, np.int32)


def read_item(wav: Path, kept: Path) -> Item:
    """The item of a recording `wav` with its .beats and .json beside it; its bands are kept in the folder `kept`."""
    facts = json.loads(wav.with_suffix(".json").read_text(encoding="utf-8"))
    bands_file = kept / f"{wav.stem}.npy"
    if bands_file.exists():
        log_bands = np.load(bands_file)
    else:
        import soundfile

        sound, rate = soundfile.read(wav, dtype="float32", always_2d=True)
        if rate != BASE_RATE:
            raise ValueError(f"{wav}: {rate} Hz, {BASE_RATE:g} expected")
        log_bands = np.log(bands_of(sound.mean(axis=1)) + LOG_FLOOR).astype(np.float16)
        partial = bands_file.with_suffix(".part.npy")
        np.save(partial, log_bands)
        partial.rename(bands_file)
    beats, places = read_beats(wav.with_suffix(".beats"))
    return Item(wav.stem, str(facts.get("style", "?")), log_bands, beats, places, facts)


def reverse(item: Item) -> Item:
    """The recording played backwards: its frames as the engine would see them, its beats and stops in mirrored order.

    A window that ends with a frame begins with another one backwards, so ears of different windows shift apart.
    """
    frames = item.log_bands.shape[0]
    seconds = frames * HOP
    ears, first = [], 0
    for ear, bands in zip(ANALYSIS_WINDOWS, BANDS_PER_WINDOW, strict=True):
        order = np.clip(frames - 2 + ear.window // BASE_HOP - np.arange(frames), 0, frames - 1)
        ears.append(item.log_bands[order, first : first + bands])
        first += bands
    stops = [[seconds - high, seconds - low] for low, high in reversed(item.facts.get("ignore", []))]
    return replace(
        item,
        log_bands=np.concatenate(ears, axis=1),
        beats=seconds - item.beats[::-1],
        places=item.places[::-1].copy(),
        facts={**item.facts, "ignore": stops},
    )


def read_items(folder: Path, jobs: int = 2) -> list[Item]:
    """All items of a folder in the order of their names; their bands are kept beside them, in `bands/`."""
    kept = folder / "bands"
    kept.mkdir(exist_ok=True)
    sounds = [wav for wav in sorted(folder.glob("*.wav")) if wav.with_suffix(".json").exists()]
    new = [wav for wav in sounds if not (kept / f"{wav.stem}.npy").exists()]
    if new:
        with multiprocessing.get_context("fork").Pool(jobs) as pool:
            pool.starmap(_keep, [(wav, kept) for wav in new], chunksize=4)
    return [read_item(wav, kept) for wav in sounds]


def _keep(wav: Path, kept: Path) -> None:
    read_item(wav, kept)
