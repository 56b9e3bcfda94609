"""A show that is danced offline, and pictures of it."""

import contextlib
import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt
from PIL import Image

from bench._locomotion_run import engine_of
from live.app.film.show_film import make_renderer
from live.app.launch_options import LaunchOptions
from live.base.stage_snapshot import Camera, StageView
from live.control.events.events import ControlEvent
from live.show.loader import LoadedShow, load_show
from live.show.show import Show
from tools.docs_films.film_file import FPS, SIZE, Picture

Float64 = npt.NDArray[np.float64]

ROOT: Final = Path(__file__).resolve().parents[2]
WARM_UP_S: Final = 0.4
"""So much is drawn before a film begins: trails and soft shadows have come by then."""


def load(patch: str) -> LoadedShow:
    """Return a show of the repository by its path from the root."""
    return load_show(ROOT / patch)


def seconds_of(loaded: LoadedShow, measures: float) -> float:
    """Return the length of so many measures at the patch's tempo [s]."""
    clock = loaded.patch.clock
    return measures * clock.beats_per_measure * 60.0 / clock.bpm


def play(
    loaded: LoadedShow, begin: float, seconds: float, *, events: Iterable[ControlEvent] = (), lead_in: float = 0.0
) -> Iterator[tuple[Show, StageView]]:
    """Yield show and view for each picture from `begin` on [s], and before it for `lead_in` [s].

    The clock goes on its own at the patch's tempo; `events` are in the order of their times.
    """
    show = loaded.start(tempo=loaded.patch.clock.bpm)
    engine, clock, inbox = engine_of(show)
    waiting = list(events)
    first = max(0, round((begin - lead_in) * FPS))
    for frame in range(first, round(begin * FPS) + round(seconds * FPS)):
        now = frame / FPS
        while waiting and waiting[0].time <= now:
            clock.set(waiting[0].time)
            inbox.put(waiting.pop(0))
            engine.frame(lambda _: None)
        clock.set(now)
        engine.frame(lambda _: None)
        yield show, engine.view


class StageCamera(contextlib.AbstractContextManager["StageCamera"]):
    """Draws the views of one show as the projector would show them."""

    def __init__(self, loaded: LoadedShow, size: tuple[int, int] = SIZE) -> None:
        self._stack = contextlib.ExitStack()
        options = LaunchOptions(size=(2 * size[0], 2 * size[1]))
        self._target, self._renderer = make_renderer(self._stack, options, loaded, fine=False)

    def draw(self, view: StageView) -> Picture:
        """Return the picture of a view; four pixels are drawn for each, for smooth edges."""
        self._renderer.draw(view, self._target.framebuffer)
        return np.asarray(Image.fromarray(np.array(self._target.read())).reduce(2))

    def __exit__(self, *_: object) -> None:
        self._stack.close()


class Projection:
    """Where places of the stage are in the picture of a show's camera."""

    def __init__(self, loaded: LoadedShow, size: tuple[int, int]) -> None:
        section = loaded.patch.camera
        self._eye = np.array(section.eye)
        ahead = np.array(section.target) - self._eye
        self._ahead = ahead / np.linalg.norm(ahead)
        side = np.cross(self._ahead, (0.0, 1.0, 0.0))
        self._side = side / np.linalg.norm(side)
        self._up = np.cross(self._side, self._ahead)
        self._middle = np.array(size) / 2.0
        self._focal = size[1] / 2.0 / math.tan(math.radians(section.field_of_view_deg) / 2.0)

    def at(self, places: Float64) -> Float64:
        """Return places (n, 3) [m] in pixels, (n, 2)."""
        seen = places - self._eye
        depth = seen @ self._ahead
        flat = np.stack([seen @ self._side, -(seen @ self._up)], axis=-1)
        return np.asarray(self._middle + self._focal * flat / depth[..., None])

    def circle(self, middle: Float64, radius: float) -> Float64:
        """Return a circle on the floor in pixels, (n, 2)."""
        angle = np.linspace(0.0, 2.0 * math.pi, 40)
        return self.at(middle + radius * np.stack([np.sin(angle), 0.0 * angle, np.cos(angle)], axis=-1))


def with_camera(loaded: LoadedShow, camera: Camera) -> LoadedShow:
    """Return the show, seen by another camera."""
    section = loaded.patch.camera.model_copy(
        update={"eye": camera.eye, "target": camera.target, "field_of_view_deg": camera.field_of_view_deg}
    )
    return replace(loaded, patch=loaded.patch.model_copy(update={"camera": section}))


def film_stage(
    loaded: LoadedShow,
    begin: float,
    seconds: float,
    *,
    events: Iterable[ControlEvent] = (),
    size: tuple[int, int] = SIZE,
    paint: Callable[[Picture, Show, StageView], Picture] | None = None,
) -> list[Picture]:
    """Return the pictures of a show from `begin` on [s]; `paint` adds to each."""
    pictures: list[Picture] = []
    wanted = round(seconds * FPS)
    with StageCamera(loaded, size) as camera:
        for show, view in play(loaded, begin, seconds, events=events, lead_in=WARM_UP_S):
            picture = camera.draw(view)
            pictures.append(picture if paint is None else paint(picture, show, view))
    return pictures[-wanted:]
