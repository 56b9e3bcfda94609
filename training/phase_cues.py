"""python -m training.phase_cues DATA...: fit the phase cues to recordings with known beats.

The features are the engine's own (`live.clock.tracking.phase_cues`), along the true beats. Prints the weights for that
module, and how often the true grid of the `--validation` recordings has the highest score of the four.
"""

from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt

from live.clock.bar_pointer.phase_choice import PLACES
from live.clock.tracking.phase_cues import QuarterFeatures
from training.features import read_beats
from training.live_score import Network, read_weights
from training.measure_cues import frames_of_beats, read_all, read_options

Floats = npt.NDArray[np.float64]

STOP: Final = 1.6
"""A beat longer than this many usual ones is a stop: what was heard before does not count any more."""
EVERY: Final = 4
"""Of each four beats one is looked at: their means over many beats are nearly the same."""
LEAST: Final = 4
WORTH: Final = 4.0
"""How many independent observations a recording is worth."""
RIDGE: Final = 100.0
STEPS: Final = 25


def read_piece(sound: Path, weights: Network) -> Floats | None:
    """Features of the four grids of a recording, (n, PLACES, features), the true one first; None if it is short."""
    times, _ = read_beats(sound.with_suffix(".beats"))
    if times.size < 2:
        return None
    collect, rows, former = QuarterFeatures(), list[Floats](), -1
    usual = np.diff(times)
    for stream, frame, index, since, interval in frames_of_beats(sound, weights):
        if usual[index] > STOP * np.median(usual):
            collect.clear()
            continue
        found = collect.step(stream.features[frame], float(stream.beat[frame]), since, interval)
        if found is not None and index != former:
            former = index
            rows.append(found)
    kept = np.array(rows[::EVERY])
    if len(kept) < LEAST:
        return None
    return np.stack([np.roll(kept, -k, axis=1).reshape(len(kept), -1) for k in range(PLACES)], axis=1)


def fit(pieces: list[Floats]) -> Floats:
    """Weights of a conditional logit for the first of each four grids (Newton's method), (features,)."""
    rows = np.concatenate(pieces)
    worth = np.concatenate([np.full(len(piece), WORTH / len(piece)) for piece in pieces])
    spread = rows.std(axis=(0, 1)) + 1e-9
    rows = rows / spread
    weights = np.zeros(rows.shape[2])
    for _ in range(STEPS):
        share = _shares(rows @ weights)
        mean = np.einsum("nk,nkf->nf", share, rows)
        slope = (worth[:, None] * (mean - rows[:, 0])).sum(axis=0) + RIDGE * weights
        apart = rows - mean[:, None]
        bend = np.einsum("nk,nkf,nkg->fg", worth[:, None] * share, apart, apart, optimize=True)
        weights -= np.linalg.solve(bend + RIDGE * np.eye(weights.size), slope)
    result: Floats = weights / spread
    return result


def _shares(scores: Floats) -> Floats:
    share = np.exp(scores - scores.max(axis=1, keepdims=True))
    result: Floats = share / share.sum(axis=1, keepdims=True)
    return result


def right_grids(pieces: list[Floats], weights: Floats) -> tuple[float, float, float]:
    """(share of beats at which the true grid has the highest score, share of beats at which a grid is sure (0.97),
    how many of those are right)."""
    shares = np.concatenate([_shares(piece @ weights) for piece in pieces])
    right, sure = shares.argmax(axis=1) == 0, shares.max(axis=1) > 0.97
    return float(right.mean()), float(sure.mean()), float(right[sure].mean())


def main() -> None:
    """Command line."""
    options = read_options(__doc__)
    network = read_weights(options.weights)

    learned, held_out = (
        read_all(read_piece, part, network, options.jobs) for part in (options.data, options.validation)
    )
    weights = fit(learned)
    for row in weights.reshape(PLACES, -1):
        print("(" + ", ".join(f"{value:.2f}" for value in row) + "),")
    for name, group in (("learned", learned), ("held out", held_out)):
        if group:
            right, sure, right_if_sure = right_grids(group, weights)
            print(f"{name}: {len(group)} recordings, right {right:.3f}")
            print(f"{name}: sure {sure:.2f}, of these right {right_if_sure:.3f}")


if __name__ == "__main__":
    main()
