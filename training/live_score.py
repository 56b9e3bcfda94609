"""python -m training.live_score DATA...: the whole tracker on held-out recordings, as a stage would hear it.

A beat counts at the later of the moment it names and the moment it was named. Figures by style: F live, AMLt, F live
of downbeats, and the seconds until 4 s are wholly right for the first time.
"""

import argparse
import multiprocessing
from pathlib import Path
from typing import Any, Final

import mir_eval
import numpy as np
import numpy.typing as npt
import soundfile

from live.clock.beat_estimate import BeatEstimate
from live.clock.tracking.beat_network import BeatNetwork, NetworkWeights
from live.clock.tracking.beat_tracker import BeatTracker
from live.control.audio.analysis import beat_weights
from training.features import read_beats

Times = npt.NDArray[np.float64]

BLOCK: Final = 512
FROM: Final = 5.0
"""Scores begin here [s], as mir_eval's usual."""
LOCK: Final = 4.0


Network = tuple[NetworkWeights, ...]
"""Networks that answer together."""


def read_weights(paths: list[Path]) -> Network:
    """Weights from files that `training.train` wrote; the engine's own without any."""
    if not paths:
        return beat_weights()
    network = []
    for path in paths:
        with np.load(path) as kept:
            arrays = {name: kept[name] for name in kept.files if name != "recipe"}
            network.append(NetworkWeights.from_arrays(arrays))
    return tuple(network)


def track(sound: npt.NDArray[np.float32], rate: float, weights: Network) -> tuple[Times, Times]:
    """(beats, downbeats) at the later of the named moment and the naming [s], in the order of time."""
    tracker = BeatTracker(rate, BeatNetwork(*weights))
    named: list[BeatEstimate] = []
    for start in range(0, sound.size, BLOCK):
        for beat in tracker.feed(sound[start : start + BLOCK]):
            named = [one for one in named if one.position != beat.replaces]
            named.append(beat)
    times = np.array([max(beat.position, beat.fed) for beat in named])
    down = np.array([beat.beat == 0 for beat in named], bool)
    order = np.argsort(times)
    return times[order], times[order][down[order]]


def lock(beats: Times, found: Times) -> float:
    """The first moment [s] from which all beats of `LOCK` seconds are found, and no others; NaN if it never comes."""
    for start in np.arange(0.0, beats[-1] - LOCK, 0.25):
        true = beats[(beats >= start) & (beats < start + LOCK)]
        near = found[(found >= start - 0.07) & (found < start + LOCK + 0.07)]
        if true.size and near.size and len(mir_eval.util.match_events(true, near, 0.07)) == true.size:
            inside = near[(near >= start) & (near < start + LOCK)]
            if inside.size <= true.size + 1:
                return float(start)
    return float("nan")


def score(sound: Path, weights: Network) -> tuple[str, list[float]]:
    """(style, [F live, AMLt, F live of downbeats or NaN, lock]) of one recording."""
    import json

    facts: dict[str, Any] = json.loads(sound.with_suffix(".json").read_text(encoding="utf-8"))
    samples, rate = soundfile.read(sound, dtype="float32", always_2d=True)
    found, down = track(samples.mean(axis=1), rate, weights)
    beats, places = read_beats(sound.with_suffix(".beats"))

    def cut(times: Times) -> Times:
        times = times[(times >= FROM) & (times <= beats[-1] + 0.07)]
        for low, high in facts.get("ignore", []):
            times = times[(times < low) | (times > high)]
        return times

    true, got = cut(beats), cut(found)
    if true.size < 2 or got.size < 2:
        return facts["style"], [0.0, 0.0, float("nan"), float("nan")]
    downbeats = cut(beats[places == 1])
    usable = facts.get("has_downbeat", True) and downbeats.size > 1
    of_downbeats = float(mir_eval.beat.f_measure(downbeats, cut(down))) if usable else float("nan")
    any_level = float(mir_eval.beat.continuity(true, got)[3])
    return facts["style"], [float(mir_eval.beat.f_measure(true, got)), any_level, of_downbeats, lock(beats, found)]


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", type=Path, nargs="+")
    parser.add_argument("--weights", type=Path, nargs="+", default=[], help="networks that answer together")
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    weights = read_weights(options.weights)
    sounds = [sound for folder in options.data for sound in sorted(folder.glob("*.wav"))][:: options.every]
    with multiprocessing.get_context("fork").Pool(options.jobs) as pool:
        rows = pool.starmap(score, [(sound, weights) for sound in sounds], chunksize=2)
    every = np.array([row for _, row in rows])
    print("                            n  F live  AMLt   dbF live  lock, never")
    for style in sorted({style for style, _ in rows}):
        _tell(style, np.array([row for name, row in rows if name == style]))
    _tell("all", every)


def _tell(name: str, rows: npt.NDArray[np.float64]) -> None:
    never = int(np.isnan(rows[:, 3]).sum())
    late = np.where(np.isnan(rows[:, 3]), np.inf, rows[:, 3])
    down = np.nanmean(rows[:, 2]) if np.isfinite(rows[:, 2]).any() else float("nan")
    print(
        f"{name:24s} {len(rows):4d}  {rows[:, 0].mean():.3f}  {rows[:, 1].mean():.3f}  {down:.3f}"
        f"    {np.median(late):.1f} s, {never}"
    )


if __name__ == "__main__":
    main()
