"""Rows of the crowd bench: our metrics on a scenario beside those of RVO2 at the horizon that does best there."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from bench._peers import absence
from live.agents.scenarios.metrics import Metrics
from live.cli.bench import Row

CROWDED = ("circle", "cross", "random")
"""Scenes in which how smoothly everybody walks is held against RVO2."""
LATEST: Mapping[str, float] = {"circle": 0.95, "cross": 1.05, "formation": 1.3}
"""When our last one may arrive, as a share of when RVO2's does."""

GAP_SECONDS = 110.0
"""The bottleneck is looked at for this long [s]: nearly everybody has to be through by then."""


@dataclass(frozen=True, slots=True)
class Peer:
    """RVO2 with one time horizon [s] on one scenario: its runs, one per seed."""

    horizon: float
    runs: Sequence[Metrics]

    @property
    def name(self) -> str:
        """What it is called in the rows."""
        return f"RVO2 τ={self.horizon:g}"


def mean(runs: Sequence[Metrics], figure: str) -> float | None:
    """Mean of a figure over the runs; None where one of them has none."""
    values = [float(getattr(run, figure)) for run in runs]
    total = sum(values) / len(values) if values else math.nan
    return total if math.isfinite(total) else None


def best(peers: Sequence[Peer]) -> Peer | None:
    """Of the horizons the one with which most arrive, then the last one earliest, then with the least jerk."""

    def order(peer: Peer) -> tuple[float, float, float]:
        done, last, jerk = (mean(peer.runs, figure) for figure in ("done", "last_arrival", "jerk"))
        return (-(done or 0.0), math.inf if last is None else last, math.inf if jerk is None else jerk)

    return min(peers, key=order, default=None)


def _bar(bars: Mapping[str, float], name: str) -> float | None:
    return next((bar for kind, bar in bars.items() if name.startswith(kind)), None)


def quality_rows(name: str, runs: Sequence[Metrics], peers: Sequence[Peer]) -> list[Row]:
    """All rows of a scenario; without `peers` the ratios are null."""
    kind = name.partition("-")[0]
    smooth, endless = kind in CROWDED, kind == "random"
    rows = []
    if kind == "bottleneck":
        rows.append(_absolute(name, "done", f"share in {GAP_SECONDS:g} s", runs, peers, 0.97, least=True))
    elif not endless:
        rows.append(_absolute(name, "done", "share", runs, peers, 1.0, least=True))
    overlaps = {peer.name: float(sum(run.overlaps for run in peer.runs)) for peer in peers}
    rows.append(Row(f"{name}: overlaps", float(sum(run.overlaps for run in runs)), "", 0.0, peers=overlaps))
    rows.append(_absolute(name, "deepest", "m", runs, peers, None))
    rows.append(_absolute(name, "touching", "s/agent", runs, peers, None))
    rows.append(_ratio(name, "touching", runs, peers, 1.0 if smooth or kind == "corridor" else None))
    if not endless:
        rows.append(_absolute(name, "last_arrival", "s", runs, peers, None))
        rows.append(_ratio(name, "last_arrival", runs, peers, _bar(LATEST, name)))
        rows.append(_ratio(name, "time_ratio", runs, peers, None))
    rows.append(_ratio(name, "jerk", runs, peers, 0.5 if smooth else None))
    rows.append(_ratio(name, "turn_p99", runs, peers, 0.85 if smooth else None))
    return rows


def thesis_rows(name: str, runs: Sequence[Metrics]) -> list[Row]:
    """The thesis' rule (T108) on the same scenario, for orientation: it has no bar."""
    overlaps = Row(f"{name}, thesis' rule: overlaps", float(sum(run.overlaps for run in runs)), "")
    if name.startswith("random"):
        return [overlaps]
    return [Row(f"{name}, thesis' rule: done", mean(runs, "done"), "share"), overlaps]


def _words(figure: str) -> str:
    return {"turn_p99": "turn rate p99", "time_ratio": "mean time"}.get(figure, figure.replace("_", " "))


def _absolute(
    name: str,
    figure: str,
    unit: str,
    runs: Sequence[Metrics],
    peers: Sequence[Peer],
    bar: float | None,
    *,
    least: bool = False,
) -> Row:
    others = {peer.name: value for peer in peers if (value := mean(peer.runs, figure)) is not None}
    value = mean(runs, figure)
    return Row(f"{name}: {_words(figure)}", value, unit, bar, "at least" if least else "at most", others)


def _ratio(name: str, figure: str, runs: Sequence[Metrics], peers: Sequence[Peer], bar: float | None) -> Row:
    peer, ours = best(peers), mean(runs, figure)
    theirs = None if peer is None else mean(peer.runs, figure)
    label = f"{name}: {_words(figure)} / RVO2's best"
    if peer is None or not theirs or ours is None:
        return Row(label, None, "", bar, note=absence("pyrvo"))
    return Row(label, ours / theirs, "", bar, peers={peer.name: theirs, "ours": ours})
