"""Bridge to cameras that see performers: `--camera`, `[[stage_camera]]` of the venue, `live camera`, and
`live calibrate camera`."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from live.app.bridges import Bridge, Command, ServiceContext
from live.app.option_values import option, several
from live.app.services.service import Service
from live.base.errors import PersonError

if TYPE_CHECKING:
    from live.bridges.camera.stage_camera import CameraTables


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraOptions:
    """Launch options of cameras."""

    camera: tuple[str, ...] = option(
        (), "See a dancer with this camera: its number or name, a film, an rtsp:// address, or any for the first one. "
        "off: none, whatever the venue has. May come several times; several need marks in the venue.",
        metavar="NAME|FILE|ADDRESS", **several(),
    )  # fmt: skip
    camera_model: str = option(
        "full", "How carefully cameras look: full, or lite, which takes half the processor time.", metavar="full|lite"
    )
    camera_silhouette: bool = option(
        False, "Publish the silhouettes of those whom cameras see as shm:camera-NAME, for looks.",
        flags=("--camera-silhouette",),
    )  # fmt: skip


def venue_tables() -> "type[CameraTables]":
    """`[[stage_camera]]` of a venue."""
    from live.bridges.camera.stage_camera import CameraTables

    return CameraTables


def services(context: ServiceContext[CameraOptions]) -> Mapping[str, Service]:
    """The cameras for `--camera` or of the venue, and the phones that are cameras."""
    from live.bridges.camera.stage_camera import CameraTables

    options = context.options
    tables = () if context.venue is None else context.venue.read_tables(CameraTables).stage_camera
    asked = options.camera or tables or options.camera_silhouette or options.camera_model != "full"
    if not asked and context.phones is None:
        return {}  # most shows have no camera, and need not wait for its modules
    from live.bridges.camera.camera_service import make_camera_service

    try:
        found = make_camera_service(context, tables)
    except PersonError as error:
        if not context.resumes:
            raise
        why = f"no camera: {error}"  # a show that is resumed goes on without
        context.notices.append(lambda: why)
        return {}
    return {} if found is None else {"camera": found}


def commands() -> Mapping[str, Command]:
    """`live camera list | models | look`."""
    from live.bridges.camera.camera_command import app

    return {"camera": app}


def calibrations() -> Mapping[str, Command]:
    """`live calibrate camera`."""
    from live.bridges.camera.calibrate_command import calibrate_camera

    return {"camera": calibrate_camera}


BRIDGE = Bridge(
    name="camera", options=CameraOptions, venue_tables=venue_tables, services=services, commands=commands,
    calibrations=calibrations,
)  # fmt: skip
