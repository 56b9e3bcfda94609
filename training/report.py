"""Measures a set of training items: do attacks lie on the beats, by style; which tempi and metres are there.

`python -m training.report DIR`
"""

import argparse
import itertools
import json
import sys
import wave
from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
HOP = 441


def read(path: Path) -> Floats:
    """A mono 16 bit file as float samples."""
    with wave.open(str(path), "rb") as file:
        return np.frombuffer(file.readframes(file.getnframes()), "<i2").astype(float) / 32768


def flux(sound: Floats) -> Floats:
    """Onset strength per frame of 10 ms: the rise of the log spectrum (frames centred on their times)."""
    padded = np.pad(sound, 512)
    frames = np.lib.stride_tricks.sliding_window_view(padded, 1024)[::HOP] * np.hanning(1024)
    spectrum = np.log1p(100 * np.abs(np.fft.rfft(frames, axis=1))[:, :372])
    bands = np.add.reduceat(spectrum, np.unique(np.geomspace(1, 371, 40).astype(int)), axis=1)
    rise = np.maximum(0, bands[2:] - bands[:-2]).sum(axis=1)
    return np.asarray(np.concatenate([[0, 0], rise]))


def peaks(strength: Floats) -> Floats:
    """Times of the local maxima that stand out from their surroundings of a second."""
    around = np.lib.stride_tricks.sliding_window_view(np.pad(strength, 3, mode="edge"), 7).max(axis=1)
    mean = np.convolve(strength, np.ones(101) / 101, "same")
    return np.flatnonzero((strength >= around) & (strength > 1.3 * mean) & (strength > 0)) * HOP / 44100


def measure(stem: Path) -> dict[str, object]:
    """Share of beats with an attack within 50 ms, strength on beats and downbeats, median offset, tempo of an item."""
    facts = json.loads(stem.with_suffix(".json").read_text())
    rows = [line.split("\t") for line in stem.with_suffix(".beats").read_text().splitlines()]
    times = np.array([float(row[0]) for row in rows])
    places = np.array([int(row[1]) for row in rows])
    strength = flux(read(stem.with_suffix(".wav")))
    found = peaks(strength)
    heard = np.array([not any(a <= time <= b for a, b in facts["ignore"]) for time in times], bool)
    facts.update(share=np.nan, offset=np.nan, gain=np.nan, down=np.nan, tempo=np.nan)
    if heard.sum() > 8 and len(found):
        near = np.array([found[np.argmin(np.abs(found - time))] - time for time in times[heard]])
        hit = np.abs(near) < 0.05
        frames = np.clip((times[heard] * 100).round().astype(int), 2, len(strength) - 4)
        at = np.max([strength[frames + shift] for shift in range(-2, 4)], axis=0)
        bar = places[heard] == 1
        facts.update(
            share=hit.mean(),
            offset=float(np.median(near[hit])) if hit.any() else np.nan,
            gain=at.mean() / (strength.mean() + 1e-9),
            tempo=60 / np.median(np.diff(times)),
        )
        if bar.any() and not bar.all():
            facts["down"] = at[bar].mean() / (at[~bar].mean() + 1e-9)
    return dict(facts)


def mean(rows: Iterable[dict[str, object]], name: str) -> float:
    """The mean of a figure over the items that have it."""
    values = np.array([row[name] for row in rows], float)
    return float(np.nanmean(values)) if np.isfinite(values).any() else float("nan")


def main(arguments: list[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(prog="python -m training.report", description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--most", type=int, default=10**6, help="items to measure")
    wanted = parser.parse_args(arguments)
    rows = [measure(path.with_suffix("")) for path in sorted(wanted.folder.glob("*.json"))[: wanted.most]]
    groups: dict[str, list[dict[str, object]]] = defaultdict(list)
    for row in rows:
        groups[str(row["style"])].append(row)
    print(f"{'style':26}{'items':>6}{'on beat':>9}{'strength':>9}{'downbeat':>9}{'late ms':>9}{'tempo':>7}")
    for style, group in [*sorted(groups.items()), ("ALL", rows)]:
        late = 1000 * mean(group, "offset")
        print(
            f"{style:26}{len(group):6}{mean(group, 'share'):9.2f}{mean(group, 'gain'):9.2f}{mean(group, 'down'):9.2f}"
            f"{late:9.1f}{mean(group, 'tempo'):7.0f}"
        )
    tempi = np.array([row["tempo"] for row in rows], float)
    tempi = tempi[np.isfinite(tempi)]
    print(f"tempo: median {np.median(tempi):.0f}, from {tempi.min():.0f} to {tempi.max():.0f}")
    edges = [0, 50, 60, 70, 80, 90, 100, 110, 120, 130, 140, 150, 165, 180, 200, 400]
    for low, high in itertools.pairwise(edges):
        count = int(((tempi >= low) & (tempi < high)).sum())
        print(f"{low:4}-{high:<4}{count:5} {'#' * round(80 * count / max(1, len(tempi)))}")
    metres: dict[str, int] = defaultdict(int)
    for row in rows:
        metres[str(row["metre"])] += 1
    print("metres:", ", ".join(f"{name} {count}" for name, count in sorted(metres.items())))
    return 0


if __name__ == "__main__":
    sys.exit(main())
