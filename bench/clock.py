"""Clock: beats, measure lines and Timeline from sound as it comes in, beside aubio on the same sound; and the cost."""

import math
import multiprocessing
import tracemalloc
from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np

from bench._beat_scores import Score, lock, score
from bench._clock_pieces import BLOCK, RATE, SEEDED_AT, Heard, excerpt, listen, made_up
from bench._long_groove import slips
from live.cli.bench import Row
from live.control.audio.analysis import TrackerName, make_tracker

QUICK = ("o03_band_104", "o12_drums_punk_144", "o17_pop_34")
"""The excerpts of the quick form."""

STEADY = 0.004
"""Beats of steady music are all this near to the same distance (ratio)."""


def run(full: bool, shared: Path | None) -> list[Row]:
    """Costs, made-up pieces (tempo step, silence, one long groove), and the excerpts of `shared`/beats/open."""
    rows = [*_cost_rows(), *_made_up_rows(full)]
    paths = sorted((shared / "beats" / "open").glob("*.ogg")) if shared is not None else []
    if not full:
        paths = [path for path in paths if path.stem in QUICK]
    if not paths:
        return [*rows, *_excerpt_rows({}, {}, {}, full)]
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        ours = dict(pool.map(_ours, paths, chunksize=1))
        seeded = dict(pool.map(_seeded, paths, chunksize=1))
        theirs = dict(pool.map(_aubio, paths, chunksize=1))
    return [*rows, *_excerpt_rows(ours, seeded, theirs, full)]


def _cost_rows() -> list[Row]:
    sound, _ = made_up([(118.0, 20.0)])
    costs: dict[TrackerName, float] = {}
    network = np.zeros(0)
    for name in ("aubio", "network"):
        network = np.min([listen(sound, name).costs for _ in range(4)], axis=0)[200:]  # what others do is not ours
        costs[name] = float(network.sum() / (network.size * BLOCK / RATE))
    return [
        Row("share of a core", costs["network"], "", 0.04, "at most", {"aubio": costs["aubio"]}),
        Row("a block, p50", float(np.percentile(network, 50)) * 1e3, "ms"),
        Row("a block, p99", float(np.percentile(network, 99)) * 1e3, "ms", 3.0),
        Row("memory gained in 1,000 blocks", _gained(sound), "bytes", 4096.0),
    ]


def _gained(sound: np.typing.NDArray[np.float32]) -> float:
    tracker, _ = make_tracker("network", RATE)
    for start in range(0, 300 * BLOCK, BLOCK):
        tracker.feed(sound[start : start + BLOCK])
    tracemalloc.start()
    for start in range(300 * BLOCK, 400 * BLOCK, BLOCK):
        tracker.feed(sound[start : start + BLOCK])
    before = tracemalloc.get_traced_memory()[0]
    for start in range(400 * BLOCK, 1400 * BLOCK, BLOCK):
        tracker.feed(sound[start : start + BLOCK])
    gained = tracemalloc.get_traced_memory()[0] - before
    tracemalloc.stop()
    return float(max(gained, 0))


def _made_up_rows(full: bool) -> list[Row]:
    rows: list[Row] = []
    step, truth = made_up([(102.0, 16.0), (133.0, 14.0)])
    ours, theirs = (score(listen(step, name).named, truth) for name in ("network", "aubio"))
    rows.append(_row("tempo step 102 to 133: right again", ours.relock[0], "s", 4.0, aubio=theirs.relock[0]))
    mute, truth = made_up([(120.0, 16.0), (0.0, 8.0), (120.0, 8.0)])
    ours, theirs = (score(listen(mute, name).named, truth) for name in ("network", "aubio"))
    rows.append(
        Row("8 s of silence: beats of the grid met", ours.freewheel, "", 0.95, "at least", {"aubio": theirs.freewheel})
    )
    minutes = 30.0 if full else 1.0
    long = slips(minutes)
    rows += [
        Row(f"{minutes:g} min of one groove: beats missed or too many", float(long.missed + long.extra), "", 0.0),
        Row(f"{minutes:g} min of one groove: measure lines moved", float(long.lines_moved), "", 0.0),
        Row(f"{minutes:g} min of one groove: Timeline, p95", 1e3 * long.timeline_p95, "ms", 20.0),
    ]
    return rows


def _ours(path: Path) -> tuple[str, tuple[Score, float]]:
    sound, truth = excerpt(path)
    heard = listen(sound, "network")
    return path.stem, (score(heard.named, truth), _timeline_error(heard, truth.time, truth.changes or truth.ignore))


def _seeded(path: Path) -> tuple[str, tuple[Score, float]]:
    sound, truth = excerpt(path)
    return path.stem, (score(listen(sound, "network", truth).named, truth, first=SEEDED_AT + 1.0), math.nan)


def _aubio(path: Path) -> tuple[str, tuple[Score, float]]:
    sound, truth = excerpt(path)
    return path.stem, (score(listen(sound, "aubio").named, truth), math.nan)


def _timeline_error(heard: Heard, truth: np.typing.NDArray[np.float64], changes: object) -> float:
    """95th percentile of the Timeline's distance from the true beats on steady music, once it is right [ms]."""
    gaps = np.diff(truth)
    begin = lock(truth, heard.timeline, 0.0, float(truth[-1]))
    if changes or np.ptp(gaps) / np.median(gaps) > STEADY or math.isnan(begin):
        return math.nan
    late = heard.timeline[(heard.timeline > begin + 4.0) & (heard.timeline < truth[-1])]
    return 1e3 * float(np.percentile([np.min(np.abs(truth - time)) for time in late], 95)) if late.size else math.nan


Scores = Mapping[str, tuple[Score, float]]


def _excerpt_rows(ours: Scores, seeded: Scores, theirs: Scores, full: bool) -> list[Row]:
    bars = full or not ours

    def bar(value: float) -> float | None:
        return value if bars else None

    def mean(scores: Scores, key: str) -> float:
        return _mean(getattr(found, key) for found, _ in scores.values())

    def row(name: str, key: str, least: float, scores: Scores, peers: Scores) -> Row:
        peer = {"aubio": mean(peers, key)} if peers and not math.isnan(mean(peers, key)) else {}
        return Row(name, _known(mean(scores, key)), "", bar(least), "at least", peer)

    locks = [found.lock for found, _ in ours.values()]
    errors = 1e3 * np.array([error for found, _ in ours.values() for error in found.errors])
    never = float(np.isnan(locks).sum()) if locks else None
    median = float(np.median(np.nan_to_num(np.array(locks), nan=np.inf))) if locks else None
    timeline = _known(_mean(error for _, error in ours.values()))
    return [
        row("beats, F live", "f_live", 0.80, ours, theirs),
        row("beats at any level, AMLt", "amlt", 0.88, ours, theirs),
        row("beats at the right level, CMLt", "cmlt", 0.0, ours, theirs),
        row("downbeats, F live", "downbeat_live", 0.55, ours, {}),
        Row("lines later than 50 ms", _known(mean(ours, "late")), "", bar(0.01)),
        Row("seconds to lock, median", median if median is None or math.isfinite(median) else 99.0, "s", bar(4.0)),
        Row("never locked", never, "", bar(5.0)),
        Row("error of hits, median of sizes", _known(_median(np.abs(errors))), "ms", bar(12.0)),
        Row("bias of hits", _known(abs(_median(errors))), "ms", bar(5.0)),
        Row("Timeline on steady music, p95", timeline, "ms", bar(20.0)),
        row("seeded at 5 s: beats, F live", "f_live", 0.90, seeded, {}),
        row("seeded at 5 s: downbeats, F live", "downbeat_live", 0.80, seeded, {}),
    ]


def _row(name: str, value: float, unit: str, bar: float, **peers: float) -> Row:
    """A row of seconds; "never" is shown as 99."""
    shown = {peer: 99.0 if math.isnan(found) else found for peer, found in peers.items()}
    return Row(name, 99.0 if math.isnan(value) else value, unit, bar, "at most", shown)


def _mean(values: Iterable[float]) -> float:
    known = [value for value in values if not math.isnan(value)]
    return float(np.mean(known)) if known else math.nan


def _median(values: np.typing.NDArray[np.float64]) -> float:
    return float(np.median(values)) if values.size else math.nan


def _known(value: float) -> float | None:
    return None if math.isnan(value) else value
