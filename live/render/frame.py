"""The block of uniforms that all programs share, written once a frame."""

from typing import Final

import moderngl
import numpy as np
import numpy.typing as npt

from live.base.stage_view import FLOOR_MARGIN, Camera, Colour, Scene, StageView
from live.render.camera import view_matrix, world_to_clip
from live.render.shader import FRAME_BINDING

BORDER_SHOWN: Final = 0.4
"""The border of a stage that is so much [m] larger or smaller than the scene's is drawn in full."""
WALL_BEHIND: Final = 3.0
"""How far behind the stage the back wall stands [m]."""

_BLOCK: Final = np.dtype(
    [
        ("world_to_clip", "f4", (4, 4)),
        ("ray_corner", "f4", 4),
        ("ray_right", "f4", 4),
        ("ray_up", "f4", 4),
        ("eye", "f4", 4),
        ("key_direction", "f4", 4),
        ("key_light", "f4", 4),
        ("rim_light", "f4", 4),
        ("background", "f4", 4),
        ("floor_colour", "f4", 4),
        ("stage", "f4", 4),
        ("edge", "f4", 4),
        ("picture", "f4", 4),
    ]
)


def _unit(vector: tuple[float, float, float]) -> npt.NDArray[np.float64]:
    array = np.array(vector, np.float64)
    length = float(np.linalg.norm(array))
    if length < 1e-6:
        raise ValueError("look: key_direction must not be zero")
    return array / length


def _coloured(colour: Colour, last: float) -> tuple[float, float, float, float]:
    return (*colour, last)


class FrameBlock:
    """Holds the block and its buffer; `fit` when scene or size change, `write` every frame."""

    def __init__(self, ctx: moderngl.Context, scene: Scene, size: tuple[int, int]) -> None:
        self._data = np.zeros((), _BLOCK)
        self._buffer = ctx.buffer(reserve=_BLOCK.itemsize, dynamic=True)
        self.fit(scene, size)

    def fit(self, scene: Scene, size: tuple[int, int]) -> None:
        """Everything that depends on the scene and the picture's size."""
        camera, look, data = scene.camera, scene.look, self._data
        data["world_to_clip"] = world_to_clip(camera, size).T  # GLSL reads columns
        self._fit_rays(camera, size)
        width, depth = self._stage_size = scene.stage_size
        front = max(float(np.hypot(camera.eye[1], camera.eye[2] - 0.5 * depth)) - 0.5, 0.0)
        data["eye"] = (*camera.eye, front)
        light = -_unit(look.key_direction)
        light[1] = max(light[1], 0.2)  # a light from below or along the floor would cast endless shadows
        data["key_direction"] = (*light, 0.0)
        data["key_light"] = _coloured(look.key_light, 1.0)
        data["rim_light"] = _coloured(look.rim_light, look.ambient)
        data["background"] = _coloured(look.background, look.haze)
        data["floor_colour"] = _coloured(look.floor, 0.0)
        margin = FLOOR_MARGIN
        data["stage"] = (0.5 * width, 0.5 * depth, 0.5 * width + margin, 0.5 * depth + margin)
        data["picture"] = (size[0], size[1], 1.0 / size[0], 1.0 / size[1])

    def _fit_rays(self, camera: Camera, size: tuple[int, int]) -> None:
        axes = view_matrix(camera)[:3, :3]
        half_up = np.tan(0.5 * np.deg2rad(camera.field_of_view_deg))
        half_right = half_up * size[0] / size[1]
        right, up, forward = axes[0] * half_right, axes[1] * half_up, -axes[2]
        self._data["ray_corner"][:3] = forward - right - up
        self._data["ray_right"][:3] = 2.0 * right
        self._data["ray_up"][:3] = 2.0 * up

    def write(self, view: StageView) -> None:
        """What changes with the moment: brightness and the pulse of the beat; then uploads and binds the block."""
        phase = view.beat - float(np.floor(view.beat))
        pulse = (1.0 - phase) ** 3
        downbeat = 1.0 if view.phase < 1.0 else 0.55
        self._data["key_direction"][3] = pulse * downbeat
        self._data["key_light"][3] = min(max(view.brightness, 0.0), 1.0)
        self._data["floor_colour"][3] = phase
        width, depth = view.stage_size if view.stage_size[0] > 0.0 else self._stage_size
        changed = max(abs(width - self._stage_size[0]), abs(depth - self._stage_size[1]))
        self._data["edge"] = (0.5 * width, 0.5 * depth, min(changed / BORDER_SHOWN, 1.0), 0.0)
        self._buffer.write(self._data)
        self._buffer.bind_to_uniform_block(FRAME_BINDING)

    def release(self) -> None:
        """Free the buffer."""
        self._buffer.release()
