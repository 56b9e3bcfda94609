"""The scene of a patch: what the renderer begins with."""

import numpy as np

from live.base.bodies import USUAL
from live.base.stage_view import Camera, Look, Scene
from live.motion.skeleton import JOINT_COUNT
from live.show.parameter_table import numbers_of
from live.show.patch import Patch
from live.show.sections.draw import drawn

_BODIES_SEED = 23


def scene_of(patch: Patch) -> Scene:
    """What the renderer must know of a patch."""
    look = {key: value for key, value in patch.look.model_dump().items() if value is not None}
    defaults = Look()
    colours = tuple(
        group.colour if group.colour is not None else defaults.group_colours[i % len(defaults.group_colours)]
        for i, group in enumerate(patch.group)
    )
    styles = tuple(
        tuple((address, numbers_of(address, value)) for address, value in drawn(group.draw).items())
        for group in patch.group
    )
    return Scene(
        stage_size=(patch.stage.width, patch.stage.depth),
        camera=Camera(patch.camera.eye, patch.camera.target, patch.camera.field_of_view_deg),
        look=Look(**look, group_colours=colours, group_styles=styles),
        dancer_count=patch.dancer_count,
        joint_count=JOINT_COUNT,
        passes=patch.picture.passes,
        start=patch.picture.start(),
        bodies=_bodies(patch),
    )


def _bodies(patch: Patch) -> tuple[str, ...]:
    """The body of each dancer, drawn from those of the group in which she begins; nothing if all have the usual one."""
    if all(group.bodies is None for group in patch.group):
        return ()
    chance = np.random.default_rng([patch.seed, _BODIES_SEED])
    names: list[str] = []
    for group in patch.group:
        bodies = group.bodies or (USUAL,)
        names += [bodies[index] for index in chance.integers(len(bodies), size=group.dancers).tolist()]
    return tuple(names)
