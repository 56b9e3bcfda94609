"""Marks on the floor that a person clicks in a camera's picture: checked as a show uses them, written to a venue."""

import math
import os
import re
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import tomlkit
from tomlkit.exceptions import TOMLKitError

from live.app.bridges import installed_bridges
from live.base.arrays import Float64
from live.base.errors import PersonError
from live.bridges.camera.stage_camera import ANY, MOST_CAMERAS, CameraTables, StageCamera
from live.control.camera.drawn_figures import square_to_quad
from live.library.whole_file import write_with_folder
from live.motion.capture.camera_view import CameraView, calibrate, check_shape
from live.show.patch.patch_search_path import is_file
from live.show.patch.toml_model import parse_model, read_text
from live.show.venue.venue import FILE_HEADER, Venue, read_venue, venue_path

Points = tuple[tuple[float, float], ...]

LEAST_MARKS, MOST_MARKS = 4, 32
MOST_METRES: Final = 100.0
"""Farthest mark from the stage's centre [m]."""
DEFAULT_NAME: Final = "front"
_DIGITS: Final = 5
"""Decimal places of a share of the picture: 1/100 pixel."""
_MOST_LINES: Final = 16
"""Lines of the grid each way; a larger stage has a wider grid."""
_SEEN: Final = (-0.5, 1.5)
"""Shares of the picture within which the grid is drawn."""
_SAMPLES: Final = 65
"""Points of a line that are looked at to find its visible part."""
_TILTED: Final = 0.3
"""A camera looks straight down, so that no side of its picture is up, if less than this much of `up` is in it."""


def parse_points(text: str, option: str, example: str, most: float) -> Points:
    """Parse pairs of numbers up to `most`, "-2,1 2,1"; PersonError, which names the `option`, for anything else."""
    points = []
    for number, pair in enumerate(text.split(), start=1):
        match = re.fullmatch(r"([-+]?[\d.]+),([-+]?[\d.]+)", pair)
        try:
            point = (math.nan, math.nan) if match is None else (float(match[1]), float(match[2]))
        except ValueError:
            point = (math.nan, math.nan)
        if not all(abs(each) <= most for each in point):
            raise PersonError(
                f"{option}: pair {number}, {pair[:40]!r}: two numbers up to {most:g} and a comma between them expected",
                f'{option} "{example}"',
            )
        points.append(point)
    return tuple(points)


def stage_corners(width: float, depth: float) -> Points:
    """Return the stage's corners (x, z) [m] as a person walks around them, from the audience's left."""
    x, z = 0.5 * width, 0.5 * depth
    return ((-x, z), (x, z), (x, -z), (-x, -z))


@dataclass(frozen=True, slots=True)
class Clicks:
    """What a person clicked, in shares of the upright picture."""

    places: Points
    """Of the marks, in their order."""
    screen: Points = ()
    """Upper left, upper right, lower right and lower left corner of the projected picture; none or four."""
    turn_deg: int = 0
    """How far the picture was turned, counter-clockwise, to be upright."""


@dataclass(frozen=True, slots=True)
class FloorMarks:
    """The marks of one camera on the stage."""

    marks: Points
    """x and z [m]; around a convex shape."""
    stage: tuple[float, float] | None = None
    """Width and depth of the stage [m], if known."""

    def check(self) -> None:
        """Raise PersonError if no camera could be found from these marks, wherever they are seen."""
        if not LEAST_MARKS <= len(self.marks) <= MOST_MARKS:
            raise PersonError(
                f"--marks: {len(self.marks)} marks; {LEAST_MARKS} to {MOST_MARKS} are needed",
                'x and z of each on the stage in metres: --marks "-2,1 2,1 2,-2 -2,-2"',
            )
        check_shape(np.array(self.marks), "on the stage")

    def find_camera(self, clicks: Clicks, aspect: float) -> CameraView:
        """Return the camera that sees the marks at the clicked places; PersonError, with the remedy, if none does.

        `aspect`: width of the upright picture over its height.
        """
        if len(clicks.places) != len(self.marks):
            raise PersonError(
                f"{len(clicks.places)} places were clicked for {len(self.marks)} marks",
                "click each mark once, in order",
            )
        for number, (u, v) in enumerate(clicks.places, start=1):
            if not (0.0 <= u <= 1.0 and 0.0 <= v <= 1.0):
                raise PersonError(
                    f"mark {number} was clicked outside the picture, at {u:g}, {v:g}: 0 to 1 expected",
                    "shares of the picture: 0,0 is its upper left corner, 1,1 its lower right one",
                )
        view = calibrate(self.marks, clicks.places, aspect)
        right, down = (view.rotation @ np.array((0.0, -1.0, 0.0)))[:2]
        if math.hypot(right, down) > _TILTED and down < abs(right):
            turn = 180 if down < -abs(right) else 270 if right > 0.0 else 90
            raise PersonError(
                f"the picture is {'upside down' if turn == 180 else 'on its side'}",
                f"turn it (--turn-deg {(clicks.turn_deg + turn) % 360}), and click the marks again",
            )
        self._check_screen(clicks.screen)
        return view

    @staticmethod
    def _check_screen(screen: Points) -> None:
        if not screen:
            return
        if len(screen) != 4:
            raise PersonError(f"{len(screen)} corners of the screen; four are needed, or none", "click all four")
        try:
            square_to_quad(np.array(screen))
        except ValueError:
            raise PersonError(
                "the corners of the screen are not in order",
                "upper left, upper right, lower right, lower left, as the camera sees them",
            ) from None

    def miss(self, view: CameraView, clicks: Clicks) -> float:
        """Return the largest distance of a clicked place from where `view` sees its mark, in heights of the picture."""
        off = (view.project(_on_floor(np.array(self.marks))) - np.array(clicks.places)) * (view.aspect, 1.0)
        return float(np.linalg.norm(off, axis=1).max())

    def half_size(self) -> tuple[float, float]:
        """Return half the width and depth [m] of the floor that the grid covers: the stage, or up to 1 m around the
        marks."""
        if self.stage is not None:
            return 0.5 * self.stage[0], 0.5 * self.stage[1]
        x, z = np.ceil(np.abs(np.array(self.marks)).max(axis=0) + 0.5).tolist()
        return float(x), float(z)

    def grid(self, view: CameraView) -> dict[str, Any]:
        """Return what `view` sees of a grid on the floor, as values for JSON: parts of straight lines
        ((u, v), (u, v)), of the whole grid and of the audience's edge, the centre, and the distance of lines [m]."""
        half_x, half_z = self.half_size()
        step = max(1.0, math.ceil(2.0 * max(half_x, half_z) / _MOST_LINES))
        lines = [((x, -half_z), (x, half_z)) for x in _steps(half_x, step)]
        lines += [((-half_x, z), (half_x, z)) for z in _steps(half_z, step)]
        audience = ((-half_x, half_z), (half_x, half_z))
        centre = view.project(((0.0, 0.0, 0.0),))[0]
        return {
            "lines": [part for line in lines if (part := _seen_part(view, line)) is not None],
            "audience": _seen_part(view, audience),
            "centre": np.round(centre, 4).tolist() if np.isfinite(centre).all() else None,
            "step": step,
        }

    def describe(self, view: CameraView, clicks: Clicks) -> dict[str, Any]:
        """Return where the camera stands [m] and how well the marks fit, for a report."""
        x, height, z = view.position.tolist()
        field = 2.0 * math.degrees(math.atan(0.5 * view.aspect / view.focal))
        return {
            "camera_x": round(x, 2), "camera_z": round(z, 2), "camera_height": round(height, 2),
            "field_deg": round(field, 1), "off_percent": round(100.0 * self.miss(view, clicks), 2),
        }  # fmt: skip


def _on_floor(marks: Float64) -> Float64:
    return np.column_stack((marks[:, 0], np.zeros(len(marks)), marks[:, 1]))


def _steps(half: float, step: float) -> list[float]:
    """Return the multiples of `step` up to `half` either side of zero, and both ends."""
    count = math.floor(half / step + 1e-9)
    inner = [step * number for number in range(-count, count + 1)]
    return sorted({*inner, -half, half})


def _seen_part(view: CameraView, line: Points) -> list[list[float]] | None:
    """Return the ends (u, v) of the part of a line on the floor that is in the picture or near it; None for none."""
    start, end = np.array(line)
    points = view.project(_on_floor(start + np.linspace(0.0, 1.0, _SAMPLES)[:, None] * (end - start)))
    low, high = _SEEN
    seen = np.flatnonzero(((points >= low) & (points <= high)).all(axis=1))  # NaN, behind the camera, is not
    return [np.round(points[each], 4).tolist() for each in (seen[0], seen[-1])] if len(seen) > 1 else None


# -- the venue -------------------------------------------------------------------------------------------------------


def venue_cameras(venue: str | None) -> tuple[StageCamera, ...]:
    """Return the cameras of a venue, none of one that is not there yet; PersonError if its file is invalid."""
    if venue is None or not is_file(venue_path(venue)):
        return ()
    return read_venue(venue, installed_bridges().venue_tables()).read_tables(CameraTables).stage_camera


def chosen_camera(tables: Sequence[StageCamera], name: str | None) -> StageCamera:
    """Return the camera of that name, or the only one; a new one if there is none. PersonError if it is not clear."""
    if name is None and len(tables) > 1:
        raise PersonError(f"the venue has {len(tables)} cameras: {_names(tables)}", f"--name {tables[0].name}")
    found = next((each for each in tables if name in (None, each.name)), None)
    if found is not None:
        return found
    if len(tables) >= MOST_CAMERAS:
        raise PersonError(f"--name {name}: the venue has {len(tables)} cameras, {_names(tables)}; no more are used")
    wanted = DEFAULT_NAME if name is None else name
    if not 1 <= len(wanted) <= 64 or not wanted.isprintable():
        raise PersonError(f"--name {wanted[:80]!r}: 1 to 64 characters expected", f"--name {DEFAULT_NAME}")
    return StageCamera(name=wanted, source=ANY)


def _names(tables: Sequence[StageCamera]) -> str:
    return ", ".join(each.name for each in tables)


def clicked_camera(camera: StageCamera, marks: Points, clicks: Clicks) -> StageCamera:
    """Return a camera with the marks and corners that were clicked."""
    placed = zip(marks, clicks.places, strict=True)
    rows = tuple((x, z, round(u, _DIGITS), round(v, _DIGITS)) for (x, z), (u, v) in placed)
    screen = tuple((round(u, _DIGITS), round(v, _DIGITS)) for u, v in clicks.screen)
    return camera.model_copy(update={"marks": rows, "screen": screen, "turn_deg": clicks.turn_deg})


def check_can_write(venue: str) -> Path:
    """Return a venue's file; PersonError if it cannot be written, so that nobody clicks in vain."""
    path = venue_path(venue)
    if path.exists():
        if not path.is_file() or not path.stat().st_mode & 0o222 or not os.access(path, os.W_OK):
            raise PersonError(f"--venue {venue}: {path} may not be written", f"chmod u+w {path}, or another --venue")
        return path
    folder = next(each for each in path.parents if each.exists())
    if not folder.is_dir() or not os.access(folder, os.W_OK | os.X_OK):
        raise PersonError(f"--venue {venue}: {folder} may not be written", "write there, or set LIVE_CONFIG_DIR")
    return path


def write_camera(venue: str, camera: StageCamera) -> str:
    """Write a camera into a venue's file, a new one if need be, and return its path; other keys and comments stay."""
    path = check_can_write(venue)
    tables = installed_bridges().venue_tables()
    before = read_text(path, "venue") if is_file(path) else ""
    parse_model(before, str(path), Venue, "venue", tables=tables)
    try:
        text = update_camera_toml(before, venue, camera)
    except TOMLKitError as error:
        raise PersonError(f"{path}: {error}", "correct the file, and save again") from None
    parse_model(text, str(path), Venue, "venue", tables=tables)
    write_with_folder(text.encode(), path, "--venue")
    return str(path)


def update_camera_toml(text: str, venue: str, camera: StageCamera) -> str:
    """Return the TOML `text` (empty for a new file of a venue) with a camera; all else is kept, with comments."""
    document = tomlkit.parse(text or f"{FILE_HEADER}name = {tomlkit.item(venue).as_string()}\n")
    if "stage_camera" not in document:
        document.add(tomlkit.nl())
        document["stage_camera"] = tomlkit.aot()
    tables: Any = document["stage_camera"]
    table = next((each for each in tables if each.get("name") == camera.name), None)
    if table is None:
        fresh: Any = tomlkit.table() if isinstance(tables, tomlkit.items.AoT) else tomlkit.inline_table()
        fresh["name"] = camera.name
        tables.append(fresh)
        table = tables[-1]
    if table.get("source", ANY) != camera.source or "source" not in table:
        table["source"] = camera.source
    if camera.turn_deg or "turn_deg" in table:
        table["turn_deg"] = camera.turn_deg
    table["marks"] = _rows(camera.marks)
    if isinstance(tables, tomlkit.items.AoT):
        table["marks"].comment(f"clicked {time.strftime('%Y-%m-%d')}")
    if camera.screen:
        table["screen"] = _rows(camera.screen)
    elif "screen" in table:
        del table["screen"]
    return tomlkit.dumps(document)


def _rows(points: Sequence[Sequence[float]]) -> Any:
    """Return points as a TOML array, whole numbers without a point."""
    return tomlkit.item([[int(each) if float(each).is_integer() else each for each in point] for point in points])
