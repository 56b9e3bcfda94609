"""Command `live camera`: which cameras there are, the pose models, and what a camera sees."""

import json
import time
from typing import Annotated, Any, Final

import typer

app = typer.Typer(help="Cameras that see performers: list them, get the pose models, look through one.")

MOST_PEOPLE: Final = 8


@app.command("list")
def list_cameras(
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object instead.")] = False,
) -> None:
    """List the cameras of this machine (Linux), and say whether the pose models are installed."""
    from live.base.system.features import video_devices
    from live.control.camera.model_files import models_report

    found = video_devices() or []
    if as_json:
        print(json.dumps({"cameras": [{"device": device, "name": name} for device, name in found]}))
        return
    for device, name in found:
        print(f"{device}  {name}")
    if not found:
        print("no camera found; a film or an rtsp:// address can be named instead")
    print(models_report())


@app.command("models")
def models(
    source: Annotated[
        str | None, typer.Option("--from", help="The package as a file, on a machine without network.", metavar="FILE")
    ] = None,
    again: Annotated[bool, typer.Option("--again", help="Get them even if they are installed.")] = False,
) -> None:
    """Get the pose models once; during a show nothing is downloaded.

    They are MediaPipe's (Apache-2.0), taken by their hashes out of the npm package @mediapipe/pose, or out of the
    Python package mediapipe 0.10.21, which lacks what phones need.
    """
    from live.control.camera.model_files import install_models, models_report, phone_folder

    if again or source is not None or phone_folder() is None:
        install_models(source)
    print(models_report())


@app.command("look")
def look(
    camera: Annotated[str, typer.Argument(help="Its number or name, a film, or an rtsp:// address.")] = "",
    seconds: Annotated[float, typer.Option(help="How long to look.", min=1.0, max=3600.0)] = 10.0,
    people: Annotated[int, typer.Option(help="How many people to follow.", min=1, max=MOST_PEOPLE)] = 1,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object at the end instead.")] = False,
) -> None:
    """Look through a camera without a show: how many people it sees, how fast, and in what light."""
    from live.bridges.camera.camera_service import check_installed
    from live.control.camera.camera_eye import CameraEye
    from live.control.camera.camera_plan import parse_camera
    from live.control.camera.frame_source import FrameSource
    from live.control.camera.model_files import DETECTOR, FULL, checked_model
    from live.control.camera.pose_models import LandmarkModel, PersonDetector

    source = FrameSource(parse_camera(camera, "live camera look"))
    check_installed()
    eye = CameraEye(PersonDetector(checked_model(DETECTOR)), LandmarkModel(checked_model(FULL)), people)
    source.start()
    end, said, last = time.perf_counter() + seconds, 0.0, 0
    begin, looked, seen, spent = time.perf_counter(), 0, 0, 0.0
    told: dict[str, Any] = {}
    try:
        while (now := time.perf_counter()) < end:
            frame = source.newest(last, 0.5)
            if frame is not None:
                started = time.process_time()
                last, found = frame.number, eye.look(frame.picture, frame.time)
                spent += time.process_time() - started
                looked, seen = looked + 1, seen + bool(found)
            told = {
                **source.status(), "people": len(eye.people), "light": eye.light.word or "good",
                "brightness": round(eye.light.brightness, 2), "still_figures": eye.still_figures,
                "upside_down": eye.is_upside_down, "rate": round(looked / max(now - begin, 1e-3), 1),
                "seen_share": round(seen / max(looked, 1), 2), "look_ms": round(1e3 * spent / max(looked, 1), 1),
            }  # fmt: skip
            if not as_json and now - said >= 1.0:
                said = now
                print("  ".join(f"{key} {value}" for key, value in told.items() if value not in ("", False)))
    finally:
        source.stop()
    if as_json:
        print(json.dumps(told))
