"""The three scenes in which locomotion is judged: what is danced, and which events come when."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np
import numpy.typing as npt

from live.control.events.events import ControlEvent, Evolve, PlaceElement
from live.show.loader import LoadedShow, load_from_patch
from live.show.patch.patch import Patch
from live.show.patch.patch_reader import parse_patch
from live.show.patch.patch_search_path import PATCHES

BPM: Final = 112.0
MEASURE_S: Final = 4.0 * 60.0 / BPM
WIDTH: Final = 12.0
DEPTH: Final = 8.0
DANCERS: Final = 24
SCENES: Final = ("thrown", "crossing", "dragged")
"""Attractors thrown at random places; spread, cross over, circle; one attractor dragged in a figure of eight."""

DRAG_SPEED: Final = 0.7
"""How fast the dragged attractor goes [m/s]."""
DRAG_HERTZ: Final = 20.0
THROW_MEASURES: Final = 3
CYCLE_MEASURES: Final = 14
"""The second scene begins again after so many measures."""

PATCH: Final = f"""
name = "locomotion"
reserve = 0
[clock]
bpm = {BPM}
beats_per_measure = 4
[stage]
width = {WIDTH}
depth = {DEPTH}
[[group]]
name = "all"
dancers = {DANCERS}
steps = ["samba x2", "side step x2", "walk x2", "kick", "reach"]
travel_step = "walk"
formation = "grid"
size = [9.0, 5.0]
"""
"""All five steps are danced in nine directions."""


@dataclass(frozen=True, slots=True)
class Take:
    """One run of one scene: `seconds` long, by chance `seed`."""

    scene: str
    seed: int
    seconds: float


@cache
def stage() -> LoadedShow:
    """The scenes' patch with its steps."""
    return load_from_patch(parse_patch(PATCH, "locomotion"), PATCHES / "locomotion.toml")


def changed(patch: Patch, **sections: dict[str, object]) -> Patch:
    """The patch with other values in its sections."""
    return patch.model_copy(
        update={name: getattr(patch, name).model_copy(update=values) for name, values in sections.items()}
    )


def events_of(take: Take) -> Iterator[ControlEvent]:
    """The events of a take in their order; each is due at its time."""
    scene = {"thrown": _thrown, "crossing": _crossing, "dragged": _dragged}[take.scene]
    return scene(take)


def _thrown(take: Take) -> Iterator[ControlEvent]:
    chance = np.random.default_rng([7, take.seed])
    time = 0.5
    while time < take.seconds:
        x, z = chance.uniform(-0.4, 0.4, 2) * (WIDTH, DEPTH)
        yield PlaceElement(
            time=time, source="bench", kind="attract", points=((float(x), float(z)),), measures=float(THROW_MEASURES)
        )
        time += THROW_MEASURES * MEASURE_S


def _crossing(take: Take) -> Iterator[ControlEvent]:
    chance = np.random.default_rng([8, take.seed])
    begin = 0.5
    while begin < take.seconds:
        lean = float(chance.uniform(-1.5, 1.5))
        yield PlaceElement(time=begin, source="bench", kind="spread", measures=4.0)
        yield PlaceElement(
            time=begin + 4 * MEASURE_S,
            source="bench",
            kind="cross",
            points=((round(lean, 3), -4.0), (round(-lean, 3), 4.0)),
            measures=5.0,
        )
        yield Evolve(time=begin + 9 * MEASURE_S, source="bench", formation="circle", measures=4.0)
        begin += CYCLE_MEASURES * MEASURE_S


def _dragged(take: Take) -> Iterator[ControlEvent]:
    way = figure_of_eight()
    offset = float(np.random.default_rng([9, take.seed]).uniform(0.0, len(way)))
    for number in range(int((take.seconds - 0.5) * DRAG_HERTZ)):
        time = 0.5 + number / DRAG_HERTZ
        x, z = way[int(offset + DRAG_SPEED * time * 1000.0) % len(way)]
        yield PlaceElement(
            time=time, source="bench", kind="attract", points=((float(x), float(z)),), measures=4.0, drag=True
        )


@cache
def figure_of_eight(width: float = 4.0, depth: float = 2.4) -> npt.NDArray[np.float64]:
    """A figure of eight within `width` and `depth` [m] of the middle, a point each millimetre of its way, (n, 2)."""
    angle = np.linspace(0.0, 2.0 * math.pi, 20001)
    curve = np.stack([width * np.sin(angle), depth * np.sin(2.0 * angle)], axis=1)
    length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(curve, axis=0).T))])
    at = np.arange(0.0, length[-1], 0.001)
    return np.stack([np.interp(at, length, curve[:, axis]) for axis in range(2)], axis=1)
