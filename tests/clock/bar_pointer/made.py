"""Network-like activations of a steady groove, and the beats a bar pointer tracks in them."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from live.clock.bar_pointer.bar_pointer import BarPointer

RATE = 44100.0 / 512.0
"""Frames per second."""
Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Activations:
    """Probabilities of beats and downbeats per frame, and the true beat times [frames]."""

    beat: Floats
    downbeat: Floats
    truth: Floats


def groove(
    bpm: float, metre: int, seconds: float, *, first: float = 7.3, doubt: float = 0.0, seed: int = 0
) -> Activations:
    """Beats of `metre` from frame `first` on; `doubt`: amount of noise, 0 to 1."""
    rng = np.random.default_rng(seed)
    count = int(seconds * RATE)
    truth = np.arange(first, count, 60.0 * RATE / bpm)
    beat = 0.01 + 0.15 * doubt * rng.random(count) ** 4
    downbeat = 0.3 * beat
    for number, place in enumerate(truth):
        frames = np.arange(max(int(place) - 2, 0), min(int(place) + 4, count))
        height = (0.9 - 0.6 * doubt * rng.random()) * np.exp(-0.5 * (frames - place) ** 2)
        beat[frames] = np.maximum(beat[frames], height)
        downbeat[frames] = np.maximum(downbeat[frames], height * (0.8 if number % metre == 0 else 0.1))
    return Activations(beat, np.minimum(downbeat, beat), truth)


@dataclass(frozen=True, eq=False)
class TrackedBeats:
    """Output of a pointer: frame, number in the measure and metre of each beat that passed."""

    time: Floats
    beat: npt.NDArray[np.int64]
    metre: npt.NDArray[np.int64]


def follow(pointer: BarPointer, activations: Activations, begin: int = 0, end: int | None = None) -> TrackedBeats:
    """Feeds frames `begin` to `end` and records each beat as it passes."""
    found: list[tuple[float, int, int]] = []
    for frame in range(begin, activations.beat.size if end is None else end):
        pointer.step(float(activations.beat[frame]), float(activations.downbeat[frame]))
        time = frame - pointer.since_beat
        if not found or time - found[-1][0] > 0.5 * pointer.interval:
            found.append((time, pointer.beat, pointer.metre))
    table = np.array(found).reshape(-1, 3)
    return TrackedBeats(table[:, 0], table[:, 1].astype(np.int64), table[:, 2].astype(np.int64))


def errors(followed: TrackedBeats, activations: Activations, after: float) -> Floats:
    """Error of each beat after `after` seconds, relative to the nearest true beat [s]."""
    late = followed.time[followed.time > after * RATE]
    return (late - activations.truth[np.argmin(np.abs(late[:, None] - activations.truth[None]), axis=1)]) / RATE


def beat_number_accuracy(followed: TrackedBeats, activations: Activations, metre: int, after: float) -> float:
    """Share of the beats after `after` seconds with the right number in the right metre."""
    late = followed.time > after * RATE
    truth = np.argmin(np.abs(followed.time[late, None] - activations.truth[None]), axis=1)
    return float(np.mean((followed.beat[late] == truth % metre) & (followed.metre[late] == metre)))
