"""Doubts about cameras: one that stands below the floor sees it from beneath, or nothing but its edge."""

from collections.abc import Iterator
from typing import Final

from live.show.patch.patch import Patch
from live.show.patch.score_checks import calls_of

EYE: Final = "/dance/camera/eye"


def camera_doubts(patch: Patch) -> list[str]:
    """The cameras of a patch, its scenes and its calls that stand below the floor."""
    return [
        f"{where}: the camera's eye is {-height:g} m below the floor (y = {height:g}); the floor is at y = 0"
        for where, height in dict(_heights(patch)).items()
        if height < 0.0
    ]


def _heights(patch: Patch) -> Iterator[tuple[str, float]]:
    yield "[camera]", patch.camera.eye[1]
    for view in patch.view:
        yield f"view {view.name!r}", view.eye[1]
    for scene in patch.scene:
        eye = scene.set.get(EYE)
        if isinstance(eye, tuple):
            yield f"scene {scene.name!r}", eye[1]
    for call, values, place in calls_of(patch):
        if call == EYE and len(values) > 1 and isinstance(values[1], int | float):
            yield f"{place[0]} {int(place[1]) + 1}, call {call}", float(values[1])
