"""python -m training.confidence DATA...: fit the tracker's confidence to recordings it has not learned.

A logistic regression over the beats that the whole tracker names: is each within 70 ms of a true one? Prints weights
for `live.clock.bar_pointer.observation_model`, and said against right for the `--validation` recordings.
"""

import json
import math
import multiprocessing
from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt
import soundfile

from live.clock.bar_pointer.observation_model import SHARE_LEAST, SHARE_MOST
from live.clock.tracking.beat_network import BeatNetwork
from live.clock.tracking.beat_tracker import BeatTracker
from training.features import read_beats
from training.live_score import Network, read_weights
from training.measure_cues import fit, read_options

Floats = npt.NDArray[np.float64]

BLOCK: Final = 512
TOLERANCE: Final = 0.07
FROM: Final = 3.0
"""Beats before this time are left out [s]."""
BINS: Final = 10


def named_beats(sound: Path, weights: Network) -> Floats:
    """(n, 6) for each beat named: log-odds of the grid's share, strength on the beat, off it, in between, odds by phase
    cues; whether it is right."""
    facts = json.loads(sound.with_suffix(".json").read_text(encoding="utf-8"))
    samples, rate = soundfile.read(sound, dtype="float32", always_2d=True)
    samples = samples.mean(axis=1)
    truth, _ = read_beats(sound.with_suffix(".beats"))
    tracker = BeatTracker(rate, BeatNetwork(*weights))
    rows = []
    for start in range(0, samples.size, BLOCK):
        for beat in tracker.feed(samples[start : start + BLOCK]):
            at = max(beat.position, beat.fed)
            known = not any(low <= at <= high for low, high in facts.get("ignore", []))
            inside = FROM < at < truth[-1] if truth.size else at > FROM  # without beats it is a crowd
            if known and inside and not tracker.silent:
                pointer = tracker.pointer
                share = min(max(pointer.share, SHARE_LEAST), SHARE_MOST)
                on, first, off, last = pointer.phase_strength
                right = float(np.any(np.abs(truth - at) <= TOLERANCE))
                rows.append((math.log(share / (1.0 - share)), on, off, max(first, last), pointer.phase_odds, right))
    return np.array(rows).reshape(-1, 6)


def main() -> None:
    """Command line."""
    options = read_options(__doc__)
    network = read_weights(options.weights)

    def beats(folders: list[Path]) -> Floats:
        sounds = [(sound, network) for folder in folders for sound in sorted(folder.glob("*.wav"))]
        with multiprocessing.get_context("fork").Pool(options.jobs) as pool:
            return np.concatenate(pool.starmap(named_beats, sounds, chunksize=2))

    learned = beats(options.data)
    weights = fit(learned[:, :-1], learned[:, -1])
    print(len(learned), "beats; constant, share, on, off, between, phase cues:")
    print("(", ", ".join(f"{value:.2f}" for value in (weights[-1], *weights[:-1])), ")")
    if options.validation:
        held_out = beats(options.validation)
        said = 1.0 / (1.0 + np.exp(-(held_out[:, :-1] @ weights[:-1] + weights[-1])))
        for low in np.arange(BINS) / BINS:
            inside = (said >= low) & (said < low + 1.0 / BINS)
            if inside.sum() >= 20:
                print(f"said {said[inside].mean():.2f}: right {held_out[inside, -1].mean():.2f} of {inside.sum()}")


if __name__ == "__main__":
    main()
