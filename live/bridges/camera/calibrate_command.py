"""Command `live calibrate camera`: marks on the floor are clicked in a camera's picture and written to the venue."""

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

if TYPE_CHECKING:
    from live.bridges.camera.floor_marks import Clicks, FloorMarks, Points
    from live.bridges.camera.stage_camera import StageCamera
    from live.control.camera.camera_plan import CameraAddress
    from live.control.camera.frame_source import FrameSource
    from live.motion.capture.camera_view import CameraView

MARKS_PORT: Final = 8012
EDGE: Final = 1920
"""Longer edge [pixels] of the largest picture in which marks are clicked."""
_PICTURE_S: Final = 15.0
"""Longest wait for a camera's first picture [s]."""


def calibrate_camera(
    venue: Annotated[
        str | None, typer.Option(help="The venue to write to. Default: what was found is printed.", metavar="NAME")
    ] = None,
    camera: Annotated[
        str | None,
        typer.Option(
            help="Its number or name, a film or picture of it, an rtsp:// address. Default: the venue's, or the first.",
            metavar="SOURCE",
        ),
    ] = None,
    name: Annotated[
        str | None,
        typer.Option(help="Which [[stage_camera]] of the venue. Default: the only one, or front.", metavar="NAME"),
    ] = None,
    marks: Annotated[
        str | None,
        typer.Option(
            help="x and z of each mark on the stage in metres, as one walks around them; +x is the audience's right, "
            "+z towards it. Default: those of the venue, or the corners of --stage.",
            metavar='"X,Z X,Z X,Z X,Z"',
        ),
    ] = None,
    stage: Annotated[
        str | None, typer.Option(help="Width and depth of the stage in metres, for the grid.", metavar="WxD")
    ] = None,
    clicks: Annotated[
        str | None,
        typer.Option(
            help="Where the marks are in the picture, in shares from its upper left corner: no page then.",
            metavar='"U,V U,V U,V U,V"',
        ),
    ] = None,
    screen: Annotated[
        str | None,
        typer.Option(
            help="With --clicks: the projected picture's upper left, upper right, lower right, lower left corner.",
            metavar='"U,V U,V U,V U,V"',
        ),
    ] = None,
    turn_deg: Annotated[
        int | None,
        typer.Option(help="How far its pictures have to be turned, counter-clockwise.", metavar="0|90|180|270"),
    ] = None,
    port: Annotated[int, typer.Option(help="Where the page is served, on this machine only.")] = MARKS_PORT,
    browser: Annotated[bool, typer.Option(help="Open the page in the browser.")] = True,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object instead.")] = False,
) -> None:
    """Find where a camera stands: four marks on the floor are clicked in its picture, once.

    A page opens that shows the picture. The grid that is drawn over it must lie on the floor; Save writes the marks to
    the venue. Pictures stay on this machine; none is stored. Ctrl-C ends it.
    """
    from live.app.option_values import check_range, parse_stage
    from live.base.errors import PersonError
    from live.bridges.camera.floor_marks import (
        Clicks,
        FloorMarks,
        check_can_write,
        chosen_camera,
        parse_points,
        venue_cameras,
    )
    from live.control.camera.frame_source import FrameSource

    check_range(port, "--port", 0, 65535)
    if turn_deg not in (None, 0, 90, 180, 270):
        raise PersonError(f"--turn-deg {turn_deg}: 0, 90, 180 or 270 expected", "--turn-deg 180")
    if screen is not None and clicks is None:
        raise PersonError("--screen without --clicks", "on the page its corners are clicked")
    size = None if stage is None else parse_stage(stage)
    tables = venue_cameras(venue)
    wanted = chosen_camera(tables, name)
    chosen = _chosen_marks(marks, wanted, size)
    if turn_deg not in (None, wanted.turn_deg):  # what was clicked in the picture before is elsewhere now
        wanted = wanted.model_copy(update={"turn_deg": turn_deg, "marks": (), "screen": ()})
    floor = FloorMarks(chosen, size)
    floor.check()
    places = () if clicks is None else parse_points(clicks, "--clicks", "0.2,0.8 0.8,0.8 0.7,0.5 0.3,0.5", 10.0)
    corners = wanted.screen
    if screen is not None:
        corners = parse_points(screen, "--screen", "0.1,0.1 0.9,0.1 0.9,0.5 0.1,0.5", 2.0)
    if venue is not None:
        check_can_write(venue)
    address, wanted = _chosen_source(camera, wanted, is_new=all(each.name != wanted.name for each in tables))
    source = FrameSource(address, edge=EDGE)
    source.start()
    try:
        calibration = _Calibration(floor, wanted, source, venue)
        if clicks is not None:
            calibration.use(Clicks(places, corners, wanted.turn_deg))
        else:
            calibration.ask(port, browser)
    finally:
        source.stop()
    calibration.tell(as_json)


def _chosen_marks(marks: str | None, camera: "StageCamera", stage: tuple[float, float] | None) -> "Points":
    """Return the marks of the command line, else the camera's, else the stage's corners; PersonError without any."""
    from live.base.errors import PersonError
    from live.bridges.camera.floor_marks import MOST_METRES, parse_points, stage_corners

    if marks is not None:
        return parse_points(marks, "--marks", "-2,1 2,1 2,-2 -2,-2", MOST_METRES)
    if camera.marks:
        return tuple((x, z) for x, z, _, _ in camera.marks)
    if stage is None:
        raise PersonError(
            "where are the marks on the floor?",
            'x and z of each in metres, --marks "-2,1 2,1 2,-2 -2,-2", or marks in the stage\'s corners, --stage 6x4',
        )
    return stage_corners(*stage)


def _chosen_source(
    source: str | None, camera: "StageCamera", *, is_new: bool
) -> "tuple[CameraAddress, StageCamera]":  # fmt: skip
    """Return the camera to open, of the command line or the table, and the table with what is to be kept of it."""
    from live.bridges.camera.stage_camera import ANY
    from live.control.camera.camera_plan import parse_camera

    if source is None:
        is_any = camera.source == ANY
        return parse_camera("" if is_any else camera.source, "--camera" if is_any else "[[stage_camera]]"), camera
    address = parse_camera("" if source == ANY else source)
    if address.kind != "film":
        return address, camera.model_copy(update={"source": source})
    if is_new:
        return address, camera.model_copy(update={"source": str(Path(address.place).resolve())})
    return address, camera  # a recording of the venue's camera


class _Calibration:
    """One camera's calibration, from its clicks to the report."""

    def __init__(
        self, floor: "FloorMarks", camera: "StageCamera", source: "FrameSource", venue: str | None
    ) -> None:  # fmt: skip
        self._floor, self._camera, self._source, self._venue = floor, camera, source, venue
        self._report: dict[str, Any] = {}

    def use(self, clicks: "Clicks") -> None:
        """Take clicks of the command line."""
        from live.base.errors import PersonError
        from live.bridges.camera.marks_page import turned_aspect

        frame = self._source.newest(0, _PICTURE_S)
        if frame is None:
            problem = self._source.problem or "it sends none"
            what = f"no picture of the camera {self._source.address.label}: {problem}"
            raise PersonError(what, "is it plugged in, and used by no other program?")
        height, width = frame.picture.shape[:2]
        self._keep(clicks, self._floor.find_camera(clicks, turned_aspect(width, height, clicks.turn_deg)))

    def ask(self, port: int, browser: bool) -> None:
        """Serve the page until a person has saved."""
        import asyncio

        from live.app.services.http_services import stored_key
        from live.app.services.listening_socket import page_socket
        from live.bridges.camera.marks_page import ROOT, MarksPage
        from live.control.web.http_protection import BACKLOG

        key = stored_key()
        where = "Saving prints them." if self._venue is None else f"Saving writes them to the venue {self._venue}."
        page = MarksPage(self._floor, self._camera, self._source, self._keep, where)
        with page_socket(("127.0.0.1", port), BACKLOG, "--port") as listening:
            link = f"http://127.0.0.1:{listening.getsockname()[1]}{ROOT}#key={key}"
            print(f"click the marks: {link}", file=sys.stderr, flush=True)
            if browser:
                _open_browser(link)
            asyncio.run(page.run(listening, key))

    def _keep(self, clicks: "Clicks", view: "CameraView") -> str:
        """Write what was clicked; return where, in words. Thread: any, one at a time."""
        from live.bridges.camera.floor_marks import clicked_camera, write_camera

        camera = clicked_camera(self._camera, self._floor.marks, clicks)
        file = None if self._venue is None else write_camera(self._venue, camera)
        self._report = {
            **camera.model_dump(mode="json"), **self._floor.describe(view, clicks), "file": file,
        }  # fmt: skip
        return "The marks are printed where the command runs." if file is None else f"The marks are saved in {file}."

    def tell(self, as_json: bool) -> None:
        """Print what was found."""
        from live.bridges.camera.floor_marks import update_camera_toml
        from live.bridges.camera.stage_camera import StageCamera

        report = self._report
        if as_json:
            print(json.dumps(report))
            return
        print(
            f"camera {report['name']}: {report['camera_height']} m over the floor at x {report['camera_x']}, "
            f"z {report['camera_z']}; it sees {report['field_deg']} degrees from side to side; the marks fit within "
            f"{report['off_percent']} % of the picture's height"
        )
        if report["file"] is not None:
            print(f"saved: {report['file']}")
            return
        fields = {key: report[key] for key in StageCamera.model_fields}
        text = update_camera_toml("", "hall", StageCamera.model_validate(fields))
        print("for a venue:\n\n" + text[text.index("[[stage_camera]]") :], end="")


def _open_browser(link: str) -> None:
    """Open the page, by a thread: some browsers return when they are closed."""
    import threading
    import webbrowser
    from functools import partial

    from live.base.fault_isolation import run_once
    from live.base.system.features import has_desktop

    if has_desktop():
        task = "opening the browser", partial(webbrowser.open, link)
        threading.Thread(target=run_once, args=task, daemon=True).start()
