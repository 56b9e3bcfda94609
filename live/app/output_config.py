"""Outputs of a show: placement of windows on monitors, and saving of warps and floor corners to the venue's file."""

import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from live.app.launch_options import LaunchOptions
from live.base.errors import PersonError, error_context
from live.base.fault_isolation import FAULTS
from live.base.floor_corners import floor_corners
from live.base.picture_parameters import camera_from_row, camera_values
from live.base.projector_perspective import camera_from_corners
from live.base.stage_snapshot import Camera
from live.control.events.event import ControlEvent
from live.control.registry.registry import REGISTRY
from live.render.camera import project_points
from live.render.outputs.output import Output, Point
from live.render.outputs.output_pass import read_mask
from live.render.outputs.projection import WindowLayout
from live.render.window.monitors import Monitor, UnknownMonitor, resolve_monitor
from live.show.venue.venue import Venue, venue_path

if TYPE_CHECKING:
    from live.app.session import Session


def outputs_of(venue: Venue | None, name: str | None, node: str = "") -> tuple[Output, ...]:
    """Return the outputs of a venue that a render node draws, or (`node` empty) the machine that plays the show.

    If the venue has none at all, or none for that machine, one shows the whole picture. `name`: of the venue.
    PersonError for a node that the venue does not name.
    """
    if venue is None or name is None or not venue.output:
        return (Output(node=node),)
    mine = [one for one in venue.output if (one.node or "") == node]
    if not mine and node:
        nodes = ", ".join(sorted({one.node for one in venue.output if one.node})) or "none yet"
        raise PersonError(
            f"venue {name}: no output is drawn by a node {node!r}; nodes: {nodes}",
            f'write node = "{node}" below one of its [[output]]',
        )
    folder = venue_path(name).parent
    return tuple(one.output(folder) for one in mine) or (Output(),)


def window_placement(
    options: LaunchOptions, venue: Venue | None, *, monitor: Monitor | None, fullscreen: bool, hidden: bool
) -> WindowLayout:
    """Return all windows and their monitors; raise PersonError for missing monitors.

    `--monitor` overrides the monitor of a venue with one output.
    """
    outputs = outputs_of(venue, options.venue, options.node)
    if hidden:  # a standby resumes the show without a mask whose file was lost
        outputs = tuple(one if _mask_exists(one) else replace(one, mask=None) for one in outputs)
    if len(outputs) == 1 and monitor is not None:
        outputs = (replace(outputs[0], monitor=None),)
    for number, output in enumerate(outputs):
        if output.monitor is not None:
            configured_monitor(output.monitor, f"venue {options.venue}: output.{number + 1}.monitor")
    of_venue = None if venue is None else venue.operator
    asked = options.operator or of_venue
    where = "--operator" if options.operator else f"venue {options.venue}: operator"
    operator = None if asked is None else configured_monitor(asked, where)
    return WindowLayout(
        outputs, monitor, operator, options.size, fullscreen, hidden,
        picture=None if venue is None else venue.picture_size, whole_for=_whole_for(options),
    )  # fmt: skip


def _whole_for(options: LaunchOptions) -> str:
    """Return which option needs the whole picture, in words; empty if none does."""
    asking = (
        (options.record is not None, "--record takes it"), (bool(options.share), "--share passes it on"),
        (options.web is not None, "the operator's page shows it"),
    )  # fmt: skip
    return next((words for asks, words in asking if asks), "")


def _mask_exists(output: Output) -> bool:
    try:
        return output.mask is None or read_mask(output) is not None
    except PersonError:
        return False


def configured_monitor(text: str, setting: str) -> Monitor:
    """Return the monitor; raise PersonError, which begins with `setting` and lists the monitors, if it is missing."""
    with error_context(setting):
        try:
            return resolve_monitor(text)
        except UnknownMonitor as error:
            raise PersonError(str(error), "connect it, or name another one") from None


class VenueWriter:
    """Saves outputs and values to the venue's file in a thread, in order. `save_output`: call in the main thread."""

    def __init__(self, venue: str | None, report: Callable[[str], None]) -> None:
        """`venue`: its name; without one nothing is saved. `report` gets the result in words, in any thread."""
        self._venue, self._report = venue, report
        self._lock = threading.Lock()
        self._threads: list[threading.Thread] = []

    def save_output(self, output: Output) -> None:
        """Save the output to the venue."""

        def text(path: Path, venue: str) -> str:
            from live.show.venue.venue_output_writer import updated_output_text

            return updated_output_text(path, venue, output)

        self._start_write(text)

    def save_values(self, values: Mapping[str, Mapping[str, object]]) -> None:
        """Save values, by table and key, to the venue."""

        def text(path: Path, venue: str) -> str:
            from live.show.venue.venue import updated_venue_text

            return updated_venue_text(path, venue, values, "# pointed at on the projector")

        self._start_write(text)

    def _start_write(self, text: Callable[[Path, str], str]) -> None:
        if self._venue is None:
            self._report("not saved: start with --venue NAME")
            return
        self._threads = [one for one in self._threads if one.is_alive()]
        self._threads.append(threading.Thread(target=self._write, args=(text, self._venue), name="venue"))
        self._threads[-1].start()

    def _write(self, text_of: Callable[[Path, str], str], venue: str) -> None:
        from live.library.whole_file import write_with_folder
        from live.show.venue.venue import venue_path

        path = venue_path(venue)
        try:
            with self._lock:
                text = text_of(path, venue)
                write_with_folder(text.encode(), path, "--venue")
        except (PersonError, OSError) as error:
            self._report(f"NOT SAVED: {error}; Enter tries again")
        except Exception as error:
            FAULTS.record("saving outputs", error)
            self._report(f"NOT SAVED: {type(error).__name__}: {error}; Enter tries again")
        else:
            self._report(f"saved in {path}")

    def wait(self) -> None:
        """Wait until all changes are written."""
        for thread in self._threads:
            thread.join()


DEFAULT_CORNERS = ((0.25, 0.45), (0.75, 0.45), (0.95, 0.9), (0.05, 0.9))
"""Initial corners, as shares of the picture, if the camera does not see all of them."""
MAX_CORNER_OFFSET = 0.48
"""Largest distance of seen corners from the picture's centre per axis, so that the pointer can reach them."""
CORNER_DIGITS = 5


class FloorCorners:
    """The floor's corners in the picture: reading and saving. Call `corners` and `save_output` in the main thread."""

    def __init__(self, session: "Session", writer: VenueWriter, size: Callable[[], tuple[int, int]]) -> None:
        """`size` returns the picture's size [pixels]."""
        self._session, self._writer, self._size = session, writer, size
        self._saved: tuple[Point, ...] | None = None

    def corners(self) -> tuple[Point, ...]:
        """Return the floor's corners as saved last, or as the camera sees them now."""
        projector = None if self._session.venue is None else self._session.venue.projector
        if self._saved is not None:
            return self._saved
        if projector is not None and projector.corners is not None:
            return projector.corners
        row = self._session.engine.view.picture
        return visible_corners(None if row is None else camera_from_row(row), self._stage, self._size())

    def save(self, corners: Sequence[Point]) -> str:
        """Match the camera to the projector and these floor corners, and save them to the venue.

        Return the reason in words if that fails, else an empty text.
        """
        venue = self._session.venue
        if venue is None or venue.projector is None:
            return "NOT SAVED: set the lens position in the venue's file: [projector] at = [x, y, z], in metres"
        width, height = self._size()
        try:
            camera = camera_from_corners(venue.projector.at, corners, self._stage, width / height)
        except PersonError as error:
            return f"NOT SAVED: {error}"
        self._saved = tuple((float(x), float(y)) for x, y in corners)
        for address, value in camera_values(camera).items():
            values = list(value) if isinstance(value, tuple) else [value]
            event = REGISTRY.call(address, values, self._session.clock.now(), "key")
            if isinstance(event, ControlEvent):
                self._session.inbox.put(event)
        rounded = [[round(x, CORNER_DIGITS), round(y, CORNER_DIGITS)] for x, y in self._saved]
        self._writer.save_values({"projector": {"corners": rounded, "aspect": round(width / height, CORNER_DIGITS)}})
        return ""

    @property
    def _stage(self) -> tuple[float, float]:
        stage = self._session.show.patch.stage
        return stage.width, stage.depth


def visible_corners(camera: Camera | None, stage: tuple[float, float], size: tuple[int, int]) -> tuple[Point, ...]:
    """Return a floor's corners as shares of a camera's picture; DEFAULT_CORNERS if it does not see all of them."""
    if camera is None:
        return DEFAULT_CORNERS
    floor = [(x, 0.0, z) for x, z in floor_corners(*stage)]
    forward = np.subtract(camera.target, camera.eye)
    if min(float(np.dot(np.subtract(corner, camera.eye), forward)) for corner in floor) <= 0.0:
        return DEFAULT_CORNERS  # a corner is behind the camera
    places = project_points(camera, size, floor) / size
    if not (np.isfinite(places).all() and np.abs(places - 0.5).max() < MAX_CORNER_OFFSET):
        return DEFAULT_CORNERS
    return tuple((float(x), float(y)) for x, y in places)
