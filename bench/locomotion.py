"""Locomotion: do steered dancers land where the group goes, feet on the floor? Recorded steps, then sketches."""

import tempfile
from collections.abc import Iterable, Mapping
from functools import reduce
from pathlib import Path
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from bench._locomotion_figures import Figures
from bench._locomotion_libraries import RECORDED, Part, load_library, write_library
from bench._locomotion_response import Response, responses
from bench._locomotion_run import ENGINE, SLIDING, UNCORRECTED, dance, drifting_beats
from bench._locomotion_scenes import BPM, SCENES, Take, changed, stage
from live.cli.bench import Row
from live.show.loader import LoadedShow

Float64 = npt.NDArray[np.float64]

NAIVE: Final = (SLIDING, UNCORRECTED)
EXACT: Final = {"warp_beats": 0.0, "amplitude": 0.0}
"""Where beats are judged nobody is early or late on purpose."""


Bars = Mapping[str, tuple[str, float]]
RECORDED_BARS: Final[Bars] = {
    "position_only.slide_mean": ("m/s", 0.03),
    "position_only.slide_p99": ("m/s", 0.15),
    "position_only.skating_ratio": ("", 0.04),
    "uncut_miss_m.mean": ("m", 0.20),
    "uncut_miss_m.p95": ("m", 0.45),
    "join_ratio_strict": ("", 1.3),
    "overlaps": ("", 0.0),
    "self_contact_ratio": ("", 0.01),
    "neighbour_contact_ratio": ("", 0.02),
}
"""Figures of the motion report (`live render --report`) with units and limits, for recorded libraries ..."""
SKETCHED_BARS: Final[Bars] = {**RECORDED_BARS, "uncut_miss_m.mean": ("m", 0.15)}
"""... and for sketches."""


def run(full: bool, shared: Path | None, steps: Path | None = None) -> list[Row]:
    """With `full` three seeds of 90 s; otherwise one of 31 s, which holds every part of each scene once.

    With `steps` only that folder of recordings is measured. Without `full` the salsa is the only recorded library.
    """
    seeds, seconds = ((1, 2, 3), 90.0) if full else ((1,), 31.0)
    if steps is not None:
        return recorded_rows(steps.name, load_library(steps), seeds, seconds)
    rows: list[Row] = []
    folder = shared or Path(__file__).resolve().parents[2] / "shared"
    for name in RECORDED if full else ("salsa",):
        rows += shared_rows(name, folder, seeds, seconds)
    for scene in SCENES:
        takes = [Take(scene, seed, seconds) for seed in seeds]
        rows += scene_rows(scene, takes, NAIVE if full else ())
    rows += beat_rows([Take("thrown", seed, seconds) for seed in seeds])
    rows += response_rows(seeds, 8 if full else 4)
    return rows


def shared_rows(name: str, shared: Path, seeds: tuple[int, ...], seconds: float) -> list[Row]:
    """The rows of a library of recordings in the shared folder; without values if it is not there."""
    parts = [Part(file) for file in RECORDED[name] if (shared / "mocap" / file).is_file()]
    if not parts:
        return [
            Row(f"{name}: {key} (no recordings here)", None, unit, bar) for key, (unit, bar) in RECORDED_BARS.items()
        ]
    with tempfile.TemporaryDirectory() as folder:
        write_library(shared, name, parts, Path(folder) / name)
        return recorded_rows(name, load_library(Path(folder) / name), seeds, seconds)


def recorded_rows(name: str, loaded: LoadedShow, seeds: tuple[int, ...], seconds: float) -> list[Row]:
    """The figures of a library in all scenes: each is that of the worst scene, beside it those of all."""
    found = {
        scene: together(dance(Take(scene, seed, seconds), patch=loaded.patch, graph=loaded.graph) for seed in seeds)
        for scene in SCENES
    }
    rows = report_rows(name, found, RECORDED_BARS)
    for of, words in (
        ("predicted", "to the target cut to the step's reach, at measure ends, mean"),
        ("agents", "to the agent at measure ends, mean"),
        ("between", "to the agent in all pictures, mean"),
        ("between free", "to the uncut prediction in all pictures, mean"),
    ):
        values = {scene: figure(each, of) for scene, each in found.items()}
        rows.append(_worst_row(f"{name}: {words}", values, "m", None))
    return rows


def report_rows(name: str, found: Mapping[str, Figures], bars: Bars) -> list[Row]:
    """Figures of the motion reports, means over the seeds: of the worst scene, beside it those of all."""
    return [
        _worst_row(f"{name}: {key}", {scene: _reported(each, key) for scene, each in found.items()}, unit, bar)
        for key, (unit, bar) in bars.items()
    ]


def _worst_row(name: str, values: Mapping[str, float | None], unit: str, bar: float | None) -> Row:
    known = {scene: value for scene, value in values.items() if value is not None}
    return Row(name, max(known.values(), default=None), unit, bar, peers=known)


def _reported(found: Figures, key: str) -> float | None:
    """The mean over the runs of one figure of the report; of counts the sum."""
    values: list[Any] = list(found.reports)
    for part in key.split("."):
        values = [None if value is None else value.get(part) for value in values]
    known = [float(value) for value in values if value is not None]
    if not known:
        return None
    return sum(known) if key == "overlaps" else sum(known) / len(known)


def together(found: Iterable[Figures]) -> Figures:
    """All runs as one."""
    return reduce(Figures.join_with, found)


def scene_rows(scene: str, takes: list[Take], ways: tuple[str, ...] = NAIVE) -> list[Row]:
    """The figures of one scene, beside each what the naive ways give."""
    found = {way: together(dance(take, way) for take in takes) for way in (ENGINE, *ways)}

    def row(name: str, unit: str, bar: float | None, of: str) -> Row:
        values = {way: figure(each, of) for way, each in found.items()}
        own = values.pop(ENGINE)
        return Row(f"{scene}: {name}", own, unit, bar, peers={w: v for w, v in values.items() if v is not None})

    return [
        *report_rows(scene, {scene: found[ENGINE]}, SKETCHED_BARS),
        row("foot slide in contact, mean", "m/s", 0.03, "slide"),
        row("foot slide in contact, p99", "m/s", 0.10, "slide p99"),
        row("skating ratio", "%", 1.0, "skating"),
        row("dancer to predicted agent at measure ends, mean", "m", 0.10, "predicted"),
        row("dancer to predicted agent at measure ends, p95", "m", 0.25, "predicted p95"),
        row("... as predicted last, mean", "m", 0.10, "predicted last"),
        row("... as predicted last, p95", "m", 0.25, "predicted last p95"),
        row("... prediction cut by the bench to the step's reach, mean", "m", None, "within reach"),
        row("... and p95", "m", None, "within reach p95"),
        row("... steering's own prediction, never cut, mean", "m", None, "free"),
        row("dancer to agent at measure ends, mean", "m", None, "agents"),
        row("join velocity ratio", "", 1.0, "join"),
        row("dancer to agent in all pictures, mean", "m", None, "between"),
        row("... to the uncut prediction, mean", "m", None, "between free"),
        row("body overlaps", "", 0.0, "overlaps"),
        row("share of pictures with an overlap", "%", 0.0, "overlapping"),
        row("nearest hips", "m", None, "nearest"),
        row("hips beyond the stage's edge", "m", None, "outside"),
    ]


def figure(found: Figures, of: str) -> float | None:
    """One number of what was found; None where nothing was."""
    name, _, kind = of.partition(" p9")
    if kind:
        values = _all(found, name)
        return float(np.percentile(values, 90 + int(kind))) if len(values) else None
    match name:
        case "slide" | "predicted" | "predicted last" | "within reach" | "free" | "agents" | "between" | "between free":
            values = _all(found, name)
            return float(values.mean()) if len(values) else None
        case "skating" | "overlapping":
            return 100.0 * float(np.mean(getattr(found, name)))
        case "join":
            return max(found.join, default=None)
        case _:
            return float(getattr(found, name))


def _all(found: Figures, name: str) -> Float64:
    arrays = getattr(found, name.replace(" ", "_"))
    values = np.concatenate(arrays) if arrays else np.zeros(0)
    return values * 1e3 if name in ("beats", "drawn beats") else values


def beat_rows(takes: list[Take]) -> list[Row]:
    """Beats found in the drawn poses against the Timeline, while the music's tempo drifts by eight per cent."""
    patch = changed(stage().patch, motion=dict(EXACT))
    found = together(dance(take, patch=patch, heard=drifting_beats(take.seconds, BPM)) for take in takes)
    drawn = _all(found, "drawn beats")
    return [
        Row(
            "drifting tempo: beats in the drawn poses to the Timeline, median",
            float(np.median(drawn)) if len(drawn) else None,
            "ms",
            5.0,
        ),
        Row(
            "drifting tempo: beats in the drawn poses to the Timeline, p95",
            float(np.percentile(drawn, 95)) if len(drawn) else None,
            "ms",
            20.0,
        ),
    ]


def response_rows(seeds: Iterable[int], moments: int) -> list[Row]:
    """From an attractor's packet to the first change that is seen."""
    found = [each for seed in seeds for each in responses(seed, moments)]
    return [
        Row("packet to the agents' change of course (2 cm/s), median", _worst(found, "agent_frames"), "frames"),
        Row("... of the last agent", _worst(found, "last_agent_frames"), "frames"),
        Row("packet to a foot that is set down elsewhere, median", _worst(found, "step_beats"), "beats", 5.0),
        Row("... of the last dancer", _worst(found, "last_step_beats"), "beats"),
    ]


def _worst(found: list[Response], name: str) -> float:
    return max(float(getattr(each, name)) for each in found)
