"""Where the windows of a show open: what the command line and the venue say, against the monitors there are.

Keeping how outputs are bent: into the venue's file, whole or not at all, in a thread so that no frame waits.

Where a hall's floor lies in the picture: what is known of it, and what becomes of corners that were pointed at.
"""

import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from live.app.launch_options import Wish
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
    """The outputs of a venue, one that shows all of the picture if it says nothing; `name` is the venue's."""
    if venue is None or name is None or not venue.output:
        return (Output(),)
    folder = venue_path(name).parent
    return tuple(one.output(folder) for one in venue.output)


def places_of(wish: Wish, venue: Venue | None, *, monitor: Monitor | None, fullscreen: bool, hidden: bool) -> Places:
    """All windows and where they open; PersonError for monitors that are not there. `--monitor` wins over what a
    venue with one output says."""
    outputs = outputs_of(venue, wish.venue)
    if hidden:  # who goes on with a show does so without a mask that was lost
        outputs = tuple(one if _mask_is_there(one) else replace(one, mask=None) for one in outputs)
    if len(outputs) == 1 and monitor is not None:
        outputs = (replace(outputs[0], monitor=None),)
    for number, output in enumerate(outputs):
        if output.monitor is not None:
            found(output.monitor, f"venue {wish.venue}: output.{number + 1}.monitor")
    of_venue = None if venue is None else venue.operator
    asked = wish.operator or of_venue
    where = "--operator" if wish.operator else f"venue {wish.venue}: operator"
    operator = None if asked is None else found(asked, where)
    return Places(outputs, monitor, operator, wish.size, fullscreen, hidden)


def _mask_is_there(output: Output) -> bool:
    try:
        return output.mask is None or read_mask(output) is not None
    except PersonError:
        return False


def found(text: str, where: str) -> Monitor:
    """The monitor that is meant; PersonError, beginning with `where` that was said, with those there are."""
    with named(where):
        try:
            return find_place(text)
        except UnknownMonitor as error:
            raise PersonError(str(error), "plug it in, or name another one") from None


class OutputKeeping:
    """Writes one output after the other. `keep` belongs to the main thread."""

    def __init__(self, venue: str | None, told: Callable[[str], None]) -> None:
        """`venue`: its name; without one nothing can be kept. `told` hears in words what became of it, from any
        thread."""
        self._venue, self._told = venue, told
        self._turn = threading.Lock()
        self._threads: list[threading.Thread] = []

    def keep(self, output: Output) -> None:
        """Let this output be as it is now from the next start on."""

        def text(path: Path, venue: str) -> str:
            from live.show.venue.venue_output_writer import changed_output

            return changed_output(path, venue, output)

        self._begin(text)

    def keep_values(self, values: Mapping[str, Mapping[str, object]]) -> None:
        """Let the venue say these values, by table and key, from the next start on."""

        def text(path: Path, venue: str) -> str:
            from live.show.venue.venue import changed_venue

            return changed_venue(path, venue, values, "# pointed at on the projector")

        self._begin(text)

    def _begin(self, text: Callable[[Path, str], str]) -> None:
        if self._venue is None:
            self._told("not kept: start with --venue NAME")
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
            self._told(f"NOT KEPT: {error}; Enter tries again")
        except Exception as error:
            FAULTS.note("the keeping of outputs", error)
            self._told(f"NOT KEPT: {type(error).__name__}: {error}; Enter tries again")
        else:
            self._told(f"kept in {path}")

    def wait(self) -> None:
        """Wait until all is written."""
        for thread in self._threads:
            thread.join()


GUESS = ((0.25, 0.45), (0.75, 0.45), (0.95, 0.9), (0.05, 0.9))
"""Where the corners are put while the camera does not see all of them: they are to be measured anyway."""
WITHIN = 0.48
"""They must not be farther from the picture's middle, or nobody could take hold of them."""
DIGITS = 5


class FloorKeeping:
    """`corners` and `keep` belong to the main thread."""

    def __init__(self, session: Session, keeping: OutputKeeping, size: Callable[[], tuple[int, int]]) -> None:
        """`size`: of the picture [pixels]."""
        self._session, self._keeping, self._size = session, keeping, size
        self._kept: tuple[Point, ...] | None = None

    def corners(self) -> tuple[Point, ...]:
        """The floor's corners in the picture, as they were kept last, or as the camera sees them now."""
        projector = None if self._session.venue is None else self._session.venue.projector
        if self._kept is not None:
            return self._kept
        if projector is not None and projector.corners is not None:
            return projector.corners
        row = self._session.engine.view.picture
        return seen_corners(None if row is None else camera_of(row), self._stage, self._size())

    def keep(self, corners: Sequence[Point]) -> str:
        """Let the picture be seen from the projector's place, with the floor there, and put it into the venue's file;
        why not, in words, if that cannot be, else nothing."""
        venue = self._session.venue
        if venue is None or venue.projector is None:
            return "NOT KEPT: say in the venue's file where the lens is: [projector] at = [x, y, z], in metres"
        width, height = self._size()
        try:
            camera = matched(venue.projector.at, corners, self._stage, width / height)
        except PersonError as error:
            return f"NOT KEPT: {error}"
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
    """Where a camera sees the corners of a floor, as shares of its picture; a guess where it does not."""
    if camera is None:
        return GUESS
    floor = [(x, 0.0, z) for x, z in floor_corners(*stage)]
    forward = np.subtract(camera.target, camera.eye)
    if min(float(np.dot(np.subtract(corner, camera.eye), forward)) for corner in floor) <= 0.0:
        return GUESS  # one lies behind it
    places = pixel_of(camera, size, floor) / size
    if not (np.isfinite(places).all() and np.abs(places - 0.5).max() < WITHIN):
        return GUESS
    return tuple((float(x), float(y)) for x, y in places)
