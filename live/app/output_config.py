"""Outputs of a show: placement of windows on monitors, and saving of warps and floor corners to the venue's file."""

import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from live.app.launch_options import LaunchOptions
from live.app.session import Session
from live.base.errors import PersonError, named
from live.base.fault_isolation import FAULTS
from live.base.picture_parameters import camera_of, camera_values
from live.base.projector_perspective import floor_corners, matched
from live.base.stage_snapshot import Camera
from live.control.events.event import ControlEvent
from live.control.registry.registry import REGISTRY
from live.render.camera import pixel_of
from live.render.outputs.output import Output, Point
from live.render.outputs.output_pass import read_mask
from live.render.outputs.projection import Places
from live.render.window.monitors import Monitor, UnknownMonitor, find_place
from live.show.venue.venue import Venue, venue_path


def outputs_of(venue: Venue | None, name: str | None) -> tuple[Output, ...]:
    """Return the outputs of a venue; if it has none, one that shows the whole picture. `name`: of the venue."""
    if venue is None or name is None or not venue.output:
        return (Output(),)
    folder = venue_path(name).parent
    return tuple(one.output(folder) for one in venue.output)


def places_of(
    options: LaunchOptions, venue: Venue | None, *, monitor: Monitor | None, fullscreen: bool, hidden: bool
) -> Places:
    """Return all windows and their monitors; raise PersonError for missing monitors.

    `--monitor` overrides the monitor of a venue with one output.
    """
    outputs = outputs_of(venue, options.venue)
    if hidden:  # a standby resumes the show without a mask whose file was lost
        outputs = tuple(one if _mask_is_there(one) else replace(one, mask=None) for one in outputs)
    if len(outputs) == 1 and monitor is not None:
        outputs = (replace(outputs[0], monitor=None),)
    for number, output in enumerate(outputs):
        if output.monitor is not None:
            found(output.monitor, f"venue {options.venue}: output.{number + 1}.monitor")
    of_venue = None if venue is None else venue.operator
    asked = options.operator or of_venue
    where = "--operator" if options.operator else f"venue {options.venue}: operator"
    operator = None if asked is None else found(asked, where)
    return Places(outputs, monitor, operator, options.size, fullscreen, hidden)


def _mask_is_there(output: Output) -> bool:
    try:
        return output.mask is None or read_mask(output) is not None
    except PersonError:
        return False


def found(text: str, where: str) -> Monitor:
    """Return the monitor; raise PersonError, which begins with `where` and lists the monitors, if it is missing."""
    with named(where):
        try:
            return find_place(text)
        except UnknownMonitor as error:
            raise PersonError(str(error), "connect it, or name another one") from None


class OutputKeeping:
    """Saves outputs and values to the venue's file in a thread, in order. `keep`: call in the main thread."""

    def __init__(self, venue: str | None, told: Callable[[str], None]) -> None:
        """`venue`: its name; without one nothing is saved. `told` is called with the result in words, in any thread."""
        self._venue, self._told = venue, told
        self._turn = threading.Lock()
        self._threads: list[threading.Thread] = []

    def keep(self, output: Output) -> None:
        """Save the output to the venue."""

        def text(path: Path, venue: str) -> str:
            from live.show.venue.venue_output_writer import changed_output

            return changed_output(path, venue, output)

        self._begin(text)

    def keep_values(self, values: Mapping[str, Mapping[str, object]]) -> None:
        """Save values, by table and key, to the venue."""

        def text(path: Path, venue: str) -> str:
            from live.show.venue.venue import changed_venue

            return changed_venue(path, venue, values, "# pointed at on the projector")

        self._begin(text)

    def _begin(self, text: Callable[[Path, str], str]) -> None:
        if self._venue is None:
            self._told("not saved: start with --venue NAME")
            return
        self._threads = [one for one in self._threads if one.is_alive()]
        self._threads.append(threading.Thread(target=self._write, args=(text, self._venue), name="venue"))
        self._threads[-1].start()

    def _write(self, text_of: Callable[[Path, str], str], venue: str) -> None:
        from live.app.whole_file import write_whole
        from live.show.venue.venue import venue_path

        path = venue_path(venue)
        try:
            with self._turn:
                text = text_of(path, venue)
                path.parent.mkdir(parents=True, exist_ok=True)
                write_whole(text.encode(), path, "--venue")
        except (PersonError, OSError) as error:
            self._told(f"NOT SAVED: {error}; Enter tries again")
        except Exception as error:
            FAULTS.note("saving outputs", error)
            self._told(f"NOT SAVED: {type(error).__name__}: {error}; Enter tries again")
        else:
            self._told(f"saved in {path}")

    def wait(self) -> None:
        """Wait until all changes are written."""
        for thread in self._threads:
            thread.join()


GUESS = ((0.25, 0.45), (0.75, 0.45), (0.95, 0.9), (0.05, 0.9))
"""Initial corners, as shares of the picture, if the camera does not see all of them."""
WITHIN = 0.48
"""Largest distance of seen corners from the picture's centre per axis, so that the pointer can reach them."""
DIGITS = 5


class FloorKeeping:
    """The floor's corners in the picture: reading and saving. Call `corners` and `keep` in the main thread."""

    def __init__(self, session: Session, keeping: OutputKeeping, size: Callable[[], tuple[int, int]]) -> None:
        """`size` returns the picture's size [pixels]."""
        self._session, self._keeping, self._size = session, keeping, size
        self._kept: tuple[Point, ...] | None = None

    def corners(self) -> tuple[Point, ...]:
        """Return the floor's corners as saved last, or as the camera sees them now."""
        projector = None if self._session.venue is None else self._session.venue.projector
        if self._kept is not None:
            return self._kept
        if projector is not None and projector.corners is not None:
            return projector.corners
        row = self._session.engine.view.picture
        return seen_corners(None if row is None else camera_of(row), self._stage, self._size())

    def keep(self, corners: Sequence[Point]) -> str:
        """Match the camera to the projector and these floor corners, and save them to the venue.

        Return the reason in words if that fails, else an empty text.
        """
        venue = self._session.venue
        if venue is None or venue.projector is None:
            return "NOT SAVED: set the lens position in the venue's file: [projector] at = [x, y, z], in metres"
        width, height = self._size()
        try:
            camera = matched(venue.projector.at, corners, self._stage, width / height)
        except PersonError as error:
            return f"NOT SAVED: {error}"
        self._kept = tuple((float(x), float(y)) for x, y in corners)
        for address, value in camera_values(camera).items():
            values = list(value) if isinstance(value, tuple) else [value]
            event = REGISTRY.call(address, values, self._session.clock.now(), "key")
            if isinstance(event, ControlEvent):
                self._session.inbox.put(event)
        rounded = [[round(x, DIGITS), round(y, DIGITS)] for x, y in self._kept]
        self._keeping.keep_values({"projector": {"corners": rounded, "aspect": round(width / height, DIGITS)}})
        return ""

    @property
    def _stage(self) -> tuple[float, float]:
        stage = self._session.show.patch.stage
        return stage.width, stage.depth


def seen_corners(camera: Camera | None, stage: tuple[float, float], size: tuple[int, int]) -> tuple[Point, ...]:
    """Return a floor's corners as shares of a camera's picture; `GUESS` if it does not see all of them."""
    if camera is None:
        return GUESS
    floor = [(x, 0.0, z) for x, z in floor_corners(*stage)]
    forward = np.subtract(camera.target, camera.eye)
    if min(float(np.dot(np.subtract(corner, camera.eye), forward)) for corner in floor) <= 0.0:
        return GUESS  # a corner is behind the camera
    places = pixel_of(camera, size, floor) / size
    if not (np.isfinite(places).all() and np.abs(places - 0.5).max() < WITHIN):
        return GUESS
    return tuple((float(x), float(y)) for x, y in places)
