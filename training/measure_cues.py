"""python -m training.measure_cues DATA...: fit the measure cues to recordings that the network has not learned.

The features are the engine's own (`live.clock.tracking.measure_cues`), along the true beats. Prints the weights for
that module, and on how many beats the line of the `--validation` recordings is right with and without them.
"""

import argparse
import json
import multiprocessing
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final, TypeVar

import numpy as np
import numpy.typing as npt
import soundfile

from live.clock.tracking.beat_network import ActivationStream, BeatNetwork
from live.clock.tracking.features import HOP
from live.clock.tracking.measure_cues import CONTEXT, FEATURES, BeatFeatures
from training.features import read_beats
from training.live_score import Network, read_weights

Floats = npt.NDArray[np.float64]
Read = TypeVar("Read")
Piece = tuple[Floats, npt.NDArray[np.int64], int]
"""Features in context (n, CUES), place of each beat in its measure, beats of a measure."""

BLOCK: Final = 512
RIDGE: Final = 5.0
STEPS: Final = 40
MEMORY: Final = 10.0
"""Measures over which evidence is summed for the printed figures."""


def frames_of_beats(sound: Path, weights: Network) -> Iterator[tuple[ActivationStream, int, int, float, float]]:
    """(stream, frame in it, number of the beat, frames since it, frames of the beat) of each frame of a recording
    between two beats, as the engine hears it along the true beats."""
    samples, rate = soundfile.read(sound, dtype="float32", always_2d=True)
    samples = samples.mean(axis=1)
    times, _ = read_beats(sound.with_suffix(".beats"))
    stream = ActivationStream(rate, BeatNetwork(*weights))
    for start in range(0, samples.size, BLOCK):
        for frame in range(stream.feed(samples[start : start + BLOCK])):
            moment = float(stream.position[frame])
            index = int(np.searchsorted(times, moment, side="right")) - 1
            if 0 <= index < times.size - 1:
                interval = float(times[index + 1] - times[index]) / HOP
                yield stream, frame, index, (moment - float(times[index])) / HOP, interval


def beat_features(sound: Path, weights: Network) -> tuple[Floats, npt.NDArray[np.int64]]:
    """(features (n, FEATURES), places (n,), 0 first) of the beats of a recording that are heard to their end."""
    _, places = read_beats(sound.with_suffix(".beats"))
    collect = BeatFeatures()
    rows: list[Floats] = []
    kept: list[int] = []
    for stream, frame, index, since, interval in frames_of_beats(sound, weights):
        beat, downbeat = float(stream.beat[frame]), float(stream.downbeat[frame])
        found = collect.step(stream.features[frame], beat, downbeat, since, interval)
        if found is not None:
            rows.append(found)
            kept.append(int(places[index]) - 1)
    return np.array(rows).reshape(-1, FEATURES), np.array(kept, np.int64)


def read_piece(sound: Path, weights: Network) -> Piece | None:
    """The piece of a recording with known, uninterrupted measures; None for others."""
    facts = json.loads(sound.with_suffix(".json").read_text(encoding="utf-8"))
    whole = not facts.get("ignore") and not any(str(word).startswith("then") for word in facts.get("done", []))
    if not facts.get("has_downbeat", True) or not whole:
        return None
    rows, places = beat_features(sound, weights)
    if len(rows) < 4 * CONTEXT:
        return None
    joined = np.concatenate([rows[k : len(rows) - CONTEXT + 1 + k] for k in range(CONTEXT)], axis=1)
    return joined, places[CONTEXT // 2 : len(rows) - CONTEXT // 2], int(facts["beats_per_bar"])


def fit(rows: Floats, truth: Floats) -> Floats:
    """Weights and a constant of a logistic regression (Newton's method), (columns + 1,)."""
    rows = np.column_stack((rows, np.ones(len(rows))))
    weights = np.zeros(rows.shape[1])
    ridge = RIDGE * np.append(np.ones(rows.shape[1] - 1), 0.0)
    for _ in range(STEPS):
        chance = 1.0 / (1.0 + np.exp(-(rows @ weights)))
        slope = rows.T @ (chance - truth) + ridge * weights
        bend = (rows * (chance * (1.0 - chance))[:, None]).T @ rows + np.diag(ridge + 1e-6)
        weights -= np.linalg.solve(bend, slope)
    return weights


def right_lines(pieces: list[Piece], columns: list[int], weights: Floats) -> float:
    """Mean share of beats at which the line with the most evidence so far is the right one."""
    shares = []
    for rows, places, metre in pieces:
        odds = rows[:, columns] @ weights[:-1] + weights[-1]
        score, right = np.zeros(metre), []
        for place, said in zip((places % metre).tolist(), odds.tolist(), strict=True):
            score[place] = (1.0 - 1.0 / MEMORY) * score[place] + said
            right.append(int(score.argmax()) == 0)
        shares.append(np.mean(right[8:]))
    return float(np.mean(shares))


def read_options(description: str | None) -> argparse.Namespace:
    """Read the command line of a fit: data, --weights, --validation, --jobs."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("data", type=Path, nargs="+")
    parser.add_argument("--weights", type=Path, nargs="+", default=[], help="networks that answer together")
    parser.add_argument("--validation", type=Path, nargs="*", default=[])
    parser.add_argument("--jobs", type=int, default=2)
    return parser.parse_args()


def read_all(
    read: Callable[[Path, Network], Read | None], folders: list[Path], network: Network, jobs: int
) -> list[Read]:
    """What `read` makes of each recording of some folders, except None."""
    sounds = [(sound, network) for folder in folders for sound in sorted(folder.glob("*.wav"))]
    with multiprocessing.get_context("fork").Pool(jobs) as pool:
        return [piece for piece in pool.starmap(read, sounds, chunksize=2) if piece is not None]


def main() -> None:
    """Command line."""
    options = read_options(__doc__)
    network = read_weights(options.weights)

    learned, held_out = (
        read_all(read_piece, part, network, options.jobs) for part in (options.data, options.validation)
    )
    rows = np.concatenate([piece[0] for piece in learned])
    truth = np.concatenate([(piece[1] == 0).astype(np.float64) for piece in learned])
    middle = FEATURES * (CONTEXT // 2) + FEATURES - 1
    everything = list(range(rows.shape[1]))
    both, alone = fit(rows, truth), fit(rows[:, [middle]], truth)
    print(len(learned), "recordings,", len(rows), "beats")
    print("(", ", ".join(f"{value:.3f}" for value in np.concatenate((both, alone))), ")")
    for name, group in (("learned", learned), ("held out", held_out)):
        if group:
            words = f"{right_lines(group, [middle], alone):.3f} with the network alone"
            print(f"{name}: line right {words}, {right_lines(group, everything, both):.3f} with cues")


if __name__ == "__main__":
    main()
