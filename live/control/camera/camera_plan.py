"""Which cameras there are, and what the camera process is told of them. It imports no decoder and no model, because the
show's process reads it.
"""

import re
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

from live.base.errors import PersonError
from live.base.system.features import video_devices

MODULE: Final = "live.control.camera.camera_process"
"""The module that the camera process runs."""
DRAWN_JOINTS: Final = (
    "leftUpperArm", "rightUpperArm", "leftLowerArm", "rightLowerArm", "leftHand", "rightHand",
    "leftUpperLeg", "rightUpperLeg", "leftLowerLeg", "rightLowerLeg", "leftFoot", "rightFoot",
)  # fmt: skip
"""Joints whose places in the projected picture the show tells, as the picture's viewer sees left and right."""
_SCHEMES: Final = ("rtsp://", "rtsps://", "http://", "https://", "udp://", "tcp://")


@dataclass(frozen=True, slots=True)
class CameraAddress:
    """Where a camera's pictures come from."""

    kind: str
    """`device`, `film` or `stream`."""
    place: str
    """The device's name or path, the film's path, the stream's address."""

    @property
    def label(self) -> str:
        """A short name without a password that an address may hold."""
        if self.kind != "stream":
            return Path(self.place).name or self.place
        scheme, _, rest = self.place.partition("://")
        return f"{scheme}://{rest.rpartition('@')[2]}"


def parse_camera(text: str, option: str = "--camera") -> CameraAddress:
    """Return the camera that a person named: nothing or a number for a device, its name, a film's path or an address.

    PersonError, with the names of the cameras that are there, if there is none like that.
    """
    if text.lower().startswith(_SCHEMES):
        return CameraAddress("stream", text)
    path = Path(text).expanduser()
    if text and path.is_file():
        return CameraAddress("film", str(path))
    found = video_devices()
    if found is None:
        return CameraAddress("device", text or "0")
    if not text and found:
        return CameraAddress("device", found[0][0])
    for device, name in found:
        if text in (device, re.sub(r"\D", "", device), name) or text.casefold() in name.casefold():
            return CameraAddress("device", device)
    if path.is_char_device():
        return CameraAddress("device", str(path))
    named = ", ".join(f"{name} ({device})" for device, name in found) or "no camera at all"
    raise PersonError(
        f"{option}: no camera is called {text!r}" if text else f"{option}: there is no camera",
        f"there is: {named}; or name a film or an rtsp:// address",
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraPlan:
    """One camera, as the show tells the process."""

    name: str
    kind: str
    place: str
    """The address: see `CameraAddress`."""
    turn_deg: int = 0
    marks: tuple[tuple[float, float, float, float], ...] = ()
    """Floor marks: x, z on the stage [m], and the place in the picture (fractions)."""
    screen: tuple[tuple[float, float], ...] = ()
    """Corners of the projected picture in the camera's picture, none or four."""
    silhouette: bool = False
    """Whether the silhouettes of the performers whom it sees are published."""

    def as_packet(self) -> dict[str, Any]:
        """Return it as values for the channel."""
        return asdict(self)
