"""The scene of a patch: what the renderer begins with."""

from live.base.stage_view import Camera, Look, Scene
from live.motion.skeleton import JOINT_COUNT
from live.show.patch import Patch


def scene_of(patch: Patch) -> Scene:
    """What the renderer must know of a patch."""
    look = {key: value for key, value in patch.look.model_dump().items() if value is not None}
    defaults = Look()
    colours = tuple(
        group.colour if group.colour is not None else defaults.group_colours[i % len(defaults.group_colours)]
        for i, group in enumerate(patch.group)
    )
    return Scene(
        stage_size=(patch.stage.width, patch.stage.depth),
        camera=Camera(patch.camera.eye, patch.camera.target, patch.camera.field_of_view_deg),
        look=Look(**look, group_colours=colours),
        dancer_count=patch.dancer_count,
        joint_count=JOINT_COUNT,
        passes=patch.picture.passes,
        start=patch.picture.start(),
    )
