"""Films of groups on the floor: a formation is taken, lines cross, elements act, a canon."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np
import numpy.typing as npt
from scipy.ndimage import gaussian_filter1d

from live.agents.evolutions.slot_assignment import assign
from live.agents.formations.formation import formation_of
from live.agents.formations.formation_spec import spec_from_table
from live.motion.editing.facing import heading_of
from live.show.loader import LoadedShow
from tools.docs_films.film_file import FPS, SIZE, Picture
from tools.docs_films.floor_plan import FLOOR, Canvas, FloorPlan, Points, mixed, on_screen
from tools.docs_films.stage_play import Projection, film_stage, load, play, seconds_of

PATCHES: Final = "docs/films/patches"
SWAY_S: Final = 0.3
"""Standard deviation of the filter that takes the sway of hips out of ways [s]."""
AHEAD_S: Final = 2.2


@dataclass(frozen=True, slots=True, eq=False)
class Walk:
    """Where all dancers are in each picture of a film (T pictures, A dancers)."""

    place: npt.NDArray[np.float64]
    """[m], (T, A, 2)."""
    heading: npt.NDArray[np.float64]
    """[rad], (T, A)."""
    group: npt.NDArray[np.int32]


def load_own(name: str) -> LoadedShow:
    """Return the show that was made for a film."""
    return load(f"{PATCHES}/{name}.toml")


def walk_of(loaded: LoadedShow, begin: float, seconds: float) -> Walk:
    """Dance a show, and keep where everybody is, without the sway of their hips."""
    place, heading = [], []
    group = np.zeros(0, np.int32)
    for show, view in play(loaded, begin, seconds):
        place.append(view.joint_position[:, 0][:, (0, 2)].astype(np.float64))
        heading.append(heading_of(view.joint_rotation[:, 0].astype(np.float64)))
        group = np.array(show.group)
    smooth = partial(gaussian_filter1d, sigma=SWAY_S * FPS, axis=0, mode="nearest")
    return Walk(smooth(np.array(place)), smooth(np.unwrap(heading, axis=0)), group)


class PlanView:
    """A stage from above, its dancers as they walk, and where they go."""

    def __init__(self, loaded: LoadedShow, walk: Walk, size: tuple[int, int]) -> None:
        self._stage = (loaded.patch.stage.width, loaded.patch.stage.depth)
        self._colours = [on_screen(group.colour or (0.6, 0.6, 0.6)) for group in loaded.patch.group]
        self._walk, self._size = walk, size

    def draw(self, frame: int, ways: Sequence[Points], *, slots: bool) -> Picture:
        """Return a moment with the way of each dancer; `slots`: also with its end."""
        canvas = Canvas(self._size)
        plan = FloorPlan(canvas, self._stage, (8.0, 8.0, self._size[0] - 8.0, self._size[1] - 8.0))
        colours = [self._colours[group] for group in self._walk.group]
        for way, colour in zip(ways, colours, strict=True):
            faint = mixed(colour, FLOOR, 0.4)
            if slots:
                plan.slot(way[-1], faint)
            plan.way(way, faint, 2.0)
        for dancer, colour in enumerate(colours):
            plan.dancer(self._walk.place[frame, dancer], float(self._walk.heading[frame, dancer]), colour)
        return canvas.picture()


def draw_formation() -> list[Picture]:
    """From a block into a circle: the ways of the assignment from above, then the same on the stage."""
    loaded = load_own("formation")
    begin, seconds = seconds_of(loaded, 1.0) - 0.1, seconds_of(loaded, 2.0) + 0.7
    walk = walk_of(loaded, begin, seconds)
    formation = formation_of(spec_from_table(loaded.patch.formation[0]), walk.place.shape[1], 1)
    start = walk.place[0]
    goal = formation.slots[assign(start, formation.slots)].astype(np.float64)
    view = PlanView(loaded, walk, SIZE)

    def ways(share: float) -> list[Points]:
        return [np.array((a, a + share * (b - a))) for a, b in zip(start, goal, strict=True)]

    appear = [view.draw(0, ways(share), slots=share == 1.0) for share in np.linspace(0.0, 1.0, FPS)]
    go = [view.draw(frame, ways(1.0), slots=True) for frame in range(len(walk.place))]
    return [*appear, *go, *film_stage(loaded, begin, seconds)]


def draw_crossing() -> list[Picture]:
    """Two lines change places, with the way of everybody in the next two seconds on the floor."""
    loaded = load_own("crossing")
    begin, seconds = seconds_of(loaded, 1.0) - 0.1, seconds_of(loaded, 4.0) + 0.5
    walk = walk_of(loaded, begin, seconds + AHEAD_S)
    colours = [on_screen(loaded.patch.group[group].colour or (0.6, 0.6, 0.6)) for group in walk.group]
    eye, ahead = Projection(loaded, SIZE), round(AHEAD_S * FPS)
    pictures = []
    for frame, picture in enumerate(film_stage(loaded, begin, seconds)):
        canvas = Canvas()
        canvas.paste(picture, (0, 0))
        ways = walk.place[frame : frame + ahead]
        on_floor = eye.at(np.stack([ways[..., 0], np.zeros(ways.shape[:2]), ways[..., 1]], axis=-1))
        for dancer, colour in enumerate(colours):
            canvas.line(on_floor[:, dancer], colour, 2.2)
            canvas.disc(on_floor[-1, dancer], 3.2, colour)
        pictures.append(canvas.picture())
    return pictures


def draw_elements() -> list[Picture]:
    """An attractor, a repulsor, a spreader, seen from a high place."""
    loaded = load_own("elements")
    return film_stage(loaded, seconds_of(loaded, 1.0), seconds_of(loaded, 6.0))


def draw_canon() -> list[Picture]:
    """Four groups dance one phrase, a measure apart."""
    loaded = load_own("canon")
    return film_stage(loaded, seconds_of(loaded, 4.0), seconds_of(loaded, 4.0))
