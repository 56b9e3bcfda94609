"""Views: the cameras of a patch by name, with those that every show has, as values of the picture's parameters."""

import math
from typing import Final

from live.base import picture
from live.base.stage_snapshot import Camera
from live.show.patch.cue_check import PROJECTOR
from live.show.patch.draw import Setting
from live.show.patch.patch import Patch
from live.show.patch.scene import LOOK_ADDRESSES, ViewSection
from live.show.patch.section_stage import CameraSection
from live.show.view.render_scene import camera_of_section, projector_camera, scene_of

_ANGLE: Final = 34.0
_ANGLE_FROM_ABOVE: Final = 20.0
_WIDE: Final = 1.7
"""Pictures are at least so much wider than high: then the whole stage is in these views."""
_AROUND: Final = 16.0
"""Measures in which `around` goes once around the stage."""


def camera_settings(camera: Camera, moves: CameraSection | None = None) -> dict[str, Setting]:
    """A camera and how it moves as values by address: all that `/dance/camera/...` can set."""
    moves = moves or CameraSection()
    return {
        **picture.camera_values(camera),
        "/dance/camera/orbit": 0.0 if moves.orbit_measures == 0.0 else 1.0 / moves.orbit_measures,
        "/dance/camera/following": float(moves.follow is not None),
        "/dance/camera/along": moves.along,
        "/dance/camera/plan": moves.plan,
    }


def start_row(patch: Patch) -> picture.Float64:
    """The picture's row with which a patch begins, shape (picture.SIZE,)."""
    row = picture.picture_of(scene_of(patch))
    moves = camera_settings(picture.camera_of(row), patch.camera)
    for address in ("/dance/camera/orbit", "/dance/camera/following", "/dance/camera/along", "/dance/camera/plan"):
        row[picture.BY_ADDRESS[address].where] = moves[address]
    for number, background in enumerate(patch.background, start=1):
        row[picture.BY_ADDRESS[f"/dance/background/{number}"].first] = background.seen
    for key, address in LOOK_ADDRESSES.items():
        value = getattr(patch.look, key)
        if value is not None:
            row[picture.BY_ADDRESS[address].where] = value
    return row


def view_settings(patch: Patch) -> dict[str, tuple[dict[str, Setting], str | None]]:
    """All views but `start` by name: their values, and whom they follow."""
    width, depth = patch.stage.width, patch.stage.depth
    views: dict[str, tuple[dict[str, Setting], str | None]] = {}
    front = Camera(*_from_the_front(width, depth), _ANGLE)
    turned = (front.eye[2], front.eye[1], 0.0)
    views["front"] = camera_settings(front), None
    views["side"] = camera_settings(Camera(turned, front.target, _ANGLE)), None
    views["around"] = camera_settings(front, CameraSection(orbit_measures=_AROUND)), None
    views["top"] = camera_settings(_from_above(width, depth), CameraSection(plan=1.0)), None
    projector = projector_camera(patch)
    if projector is not None:
        views[PROJECTOR] = camera_settings(projector), None
    own = {view.name.casefold().strip() for view in patch.view}
    views = {name: view for name, view in views.items() if name not in own}
    return views | {view.name: _own(view) for view in patch.view}


def _own(view: ViewSection) -> tuple[dict[str, Setting], str | None]:
    return camera_settings(camera_of_section(view), view), view.follow


def _from_the_front(width: float, depth: float) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    away = 0.54 * width / (math.tan(math.radians(0.5 * _ANGLE)) * _WIDE)
    return (0.0, 0.9 + 0.2 * away, 0.5 * depth + away), (0.0, 0.9, 0.0)


def _from_above(width: float, depth: float) -> Camera:
    half = math.tan(math.radians(0.5 * _ANGLE_FROM_ABOVE))
    height = max(0.56 * depth / half, 0.56 * width / (half * _WIDE))
    return Camera((0.0, height, 0.0), (0.0, 0.0, 0.0), _ANGLE_FROM_ABOVE)
