"""Uniform blocks that all programs share: `Frame`, written once a frame, and `Picture`, the parameters themselves."""

import math
from typing import Final

import moderngl
import numpy as np

from live.base.arrays import Float64
from live.base.parameter import SPOT_COUNT, WORLD_NAMES
from live.base.picture_parameters import (
    BACKDROP_INDICES,
    BY_ADDRESS,
    COLOURS_START,
    FLOOR_PATTERN_NAMES,
    GOBO_NAMES,
    LENS,
    LEVEL,
    MIRROR,
    SHADOW,
    STYLES_START,
    VIGNETTE,
    WORLD_PREFIX,
    camera_from_row,
    picture_row,
)
from live.base.stage_snapshot import FLOOR_MARGIN, Camera, Scene, StageView
from live.render.camera import PicturePart, Size, pixels_per_metre, view_rays, world_to_clip
from live.render.shader import FRAME_BINDING, PICTURE_BINDING, PICTURE_SIZE, PICTURE_VECTORS

BORDER_FADE: Final = 0.4
"""The border of a resized stage reaches full strength at this difference [m]."""
WALL_DISTANCE: Final = 3.0
"""Distance of the back wall from the stage [m]."""

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
        ("stage", "f4", 4),
        ("edge", "f4", 4),
        ("picture", "f4", 4),
        ("side_left", "f4", 4),
        ("side_right", "f4", 4),
        ("back_light", "f4", 4),
        ("beam_light", "f4", 4),
        ("spot_place", "f4", (SPOT_COUNT, 4)),
        ("spot_light", "f4", (SPOT_COUNT, 4)),
        ("worlds", "f4", 4),
        ("open_sky", "f4", 4),
        ("fill_above", "f4", 4),
        ("fill_below", "f4", 4),
        ("gobo", "f4", 4),
        ("whole_picture", "f4", 4),
        ("picture_part", "f4", 4),
    ]
)


VIGNETTE_STRENGTH: Final = 0.6
"""Darkening of the corners, by the square of the distance from the middle."""
ENERGY_RANGE: Final = 1.3
"""Range of the light that follows the music's energy, from silence to maximum, relative to the usual light."""
SWING_PERIOD: Final = 64.0
"""Period of swinging and drifting light [beats]."""
_SPOT_ROWS: Final = tuple(
    (BY_ADDRESS[at].first, BY_ADDRESS[f"{at}/colour"].row_slice, BY_ADDRESS[f"{at}/radius"].first)
    for at in (f"/dance/spot/{number}" for number in range(1, SPOT_COUNT + 1))
)
_SIDE, _BACK, _BEAMS = (BY_ADDRESS[f"/dance/light/{name}"].first for name in ("side", "back", "beams"))
_FILL: Final = BY_ADDRESS["/dance/light/fill"].first
_GOBOS: Final = [BY_ADDRESS[f"/dance/light/gobo/{name}"].first for name in GOBO_NAMES]
_GOBO_SIZE: Final = BY_ADDRESS["/dance/light/gobo/size"].first
_FLOOR_PATTERNS: Final = [BY_ADDRESS[f"/dance/floor/pattern/{name}"].first for name in FLOOR_PATTERN_NAMES]
_WORLDS: Final = np.array([BY_ADDRESS[WORLD_PREFIX + name].first for name in WORLD_NAMES])
ENERGY: Final = BY_ADDRESS["/dance/light/energy"].first
MIN_TARGET_DISTANCE: Final = 1e-3
"""A camera nearer to its target than this [m] is ignored; the last one stays."""


def world_shares(row: Float64) -> Float64:
    """Return the share of each world in a parameter row, shape (6,); they sum to 1, and haze fills what is left."""
    amounts = np.clip(row[_WORLDS], 0.0, 1.0)
    total = float(amounts.sum())
    if total > 1.0:
        return np.asarray(amounts / total)
    amounts[0] += 1.0 - total
    return np.asarray(amounts)


def rings_are_seen(row: Float64) -> bool:
    """Whether rings that spread from the dancers' steps are seen with these parameters: in water or as light on the
    floor."""
    return bool(world_shares(row)[WORLD_NAMES.index("water")] > 0.0 or row[_FLOOR_PATTERNS[0]] > 0.0)


class FrameUniforms:
    """The block and its buffer; call `resize` if the picture's size changes, `write` every frame."""

    def __init__(self, ctx: moderngl.Context, scene: Scene, size: Size | PicturePart) -> None:
        """Raises ValueError for a light without direction."""
        self._data = data = np.zeros((), _BLOCK)
        self._buffer = ctx.buffer(reserve=_BLOCK.itemsize, dynamic=True)
        self._numbers = np.zeros(PICTURE_VECTORS * 4, np.float32)
        self._numbers_buffer = ctx.buffer(reserve=self._numbers.nbytes, dynamic=True)
        self._initial_row = picture_row(scene)
        if not np.abs(self._initial_row[BY_ADDRESS["/dance/light/key/direction"].row_slice]).max() > 0.0:
            raise ValueError("look: key_direction must not be zero")
        self.camera_changed = self.light_changed = self.colours_changed = self.styles_changed = False
        """What has changed in the last written frame: the camera, anything that the cached backdrop shows, the groups'
        colours, their colours or styles."""
        self._row = self._initial_row.copy()
        self._spots_changed = True
        self.worlds: dict[str, float] = {}
        """Share of each world, by name; they sum to 1."""
        self.vignette_at_end = True
        """Whether the film curve includes the vignette; otherwise a pass draws it."""
        self.camera = scene.camera
        """The camera of the last written frame."""
        self.world_to_clip: Float64 = np.eye(4)
        """Its matrix from world to clip space, of the part that is drawn."""
        self.light = data["key_direction"][:3]
        """Direction towards the key light, a unit vector, shape (3,)."""
        self.part = PicturePart.of(size)
        """The part of the picture that is drawn."""
        self.set_stage_size(scene.stage_size)
        self.resize(size)
        self._set_light(self._row)

    def begin_anew(self) -> None:
        """Forget all moments: go on from the scene's parameters."""
        self._apply_row(self._initial_row)

    def set_stage_size(self, stage_size: tuple[float, float]) -> None:
        """Set the scene's stage: width and depth [m]."""
        width, depth = self._stage_size = stage_size
        margin = FLOOR_MARGIN
        self._data["stage"] = (0.5 * width, 0.5 * depth, 0.5 * width + margin, 0.5 * depth + margin)
        self._set_camera(self.camera)

    def resize(self, size: Size | PicturePart) -> None:
        """Set a new size of the picture [pixels], or another part of it."""
        part = self.part = PicturePart.of(size)
        for name, (width, height) in (("picture", part.size), ("whole_picture", part.whole)):
            self._data[name] = width, height, 1.0 / width, 1.0 / height
        self._data["picture_part"] = part.left, part.bottom, *part.share
        self._set_camera(self.camera)

    def _set_camera(self, camera: Camera) -> None:
        """Set the camera."""
        data, self.camera = self._data, camera
        self.world_to_clip = world_to_clip(camera, self.part)
        data["world_to_clip"] = self.world_to_clip.T  # GLSL reads columns
        for name, ray in zip(("ray_corner", "ray_right", "ray_up"), view_rays(camera, self.part), strict=True):
            data[name][:3] = ray
        data["ray_corner"][3] = pixels_per_metre(camera, self.part)
        front = max(float(np.hypot(camera.eye[1], camera.eye[2] - 0.5 * self._stage_size[1])) - 0.5, 0.0)
        data["eye"] = (*camera.eye, front)

    def _set_light(self, row: Float64) -> None:
        """Set the light from a parameter row."""

        def of(address: str) -> Float64:
            return row[BY_ADDRESS[f"/dance/light/{address}"].row_slice]

        data, direction = self._data, of("key/direction")
        length = float(np.linalg.norm(direction))
        if length > 1e-6:
            light = -(direction / length)
            light[1] = max(light[1], 0.2)  # a light from below or along the floor would cast endless shadows
            data["key_direction"][:3] = light
        data["key_light"][:3] = of("key/colour") * of("key")
        data["rim_light"][:3] = of("rim/colour") * of("rim")
        data["side_left"][:3] = of("side/left") * of("side")
        data["side_right"][:3] = of("side/right") * of("side")
        data["back_light"][:3] = of("back/colour") * of("back")
        data["beam_light"][:3] = of("beams/colour") * of("beams")
        data["fill_above"][:3] = of("fill/above") * of("fill")
        data["fill_below"][:3] = of("fill/below") * of("fill")
        haze, studio, paper, constellation, water, dusk = shares = world_shares(row).tolist()
        self.worlds = dict(zip(WORLD_NAMES, shares, strict=True))
        data["worlds"] = studio, paper, constellation, water
        data["open_sky"] = dusk, haze, studio + paper + dusk, 0.0
        self._numbers[:PICTURE_SIZE] = row[:PICTURE_SIZE]
        self._numbers_buffer.write(self._numbers)

    def write(self, view: StageView) -> None:
        """Write the values of a moment (parameter row, brightness, pulse of the beat), upload and bind the block."""
        self._apply_row(self._initial_row if view.picture is None else view.picture)
        phase = view.beat - float(np.floor(view.beat))
        pulse = (1.0 - phase) ** 3
        downbeat = 1.0 if view.phase < 1.0 else 0.55
        self._data["key_direction"][3] = pulse * downbeat
        answers = 1.0 + self._row[ENERGY] * ENERGY_RANGE * (min(max(view.energy, 0.0), 1.0) - 0.5)
        self._data["key_light"][3] = min(max(view.brightness, 0.0), 1.0) * self._row[LEVEL] * answers
        self._data["beam_light"][3] = view.beat % SWING_PERIOD
        self._write_spots(view)
        self._write_gobo(view)
        width, depth = view.stage_size if view.stage_size[0] > 0.0 else self._stage_size
        changed = max(abs(width - self._stage_size[0]), abs(depth - self._stage_size[1]))
        self._data["edge"] = (0.5 * width, 0.5 * depth, min(changed / BORDER_FADE, 1.0), phase)
        self._data["back_light"][3] = VIGNETTE_STRENGTH * self._row[VIGNETTE] * self.vignette_at_end
        self.upload()

    def upload(self) -> None:
        """Upload the block and bind it, and the picture's parameters."""
        self._buffer.write(self._data)
        self._buffer.bind_to_uniform_block(FRAME_BINDING)
        self._numbers_buffer.bind_to_uniform_block(PICTURE_BINDING)

    def _write_spots(self, view: StageView) -> None:
        """Write the follow spots; w of the first one's light is 1 if any is lit, of the next two their range."""
        data, first, end = self._data, SPOT_COUNT, 0
        if not (self._spots_changed or self.spots_lit):
            return
        self._spots_changed = False
        for number, (level, colour, radius) in enumerate(_SPOT_ROWS):
            strength = float(self._row[level])
            data["spot_light"][number, :3] = self._row[colour] * strength
            data["spot_place"][number] = (view.spot[number, 0], view.spot[number, 1], self._row[radius], strength)
            if strength > 0.0:
                first, end = min(first, number), number + 1
        data["spot_light"][:3, 3] = float(end > 0), first, end

    def _write_gobo(self, view: StageView) -> None:
        """Write how the pattern in the key light is turned."""
        angle, size = math.tau * view.gobo_turns, float(self._row[_GOBO_SIZE])
        self._data["gobo"] = math.cos(angle) / size, math.sin(angle) / size, float(self._row[_GOBOS].sum()), 0.0

    def _apply_row(self, row: Float64) -> None:
        """Apply a parameter row, and set the flags of what has changed."""
        last = self._row
        self.camera_changed = self.light_changed = self.colours_changed = self.styles_changed = False
        if np.array_equal(row, last):
            return
        self.camera_changed = not np.array_equal(row[LENS], last[LENS])
        self.light_changed = not np.array_equal(row[BACKDROP_INDICES], last[BACKDROP_INDICES])
        self.colours_changed = not np.array_equal(row[COLOURS_START:STYLES_START], last[COLOURS_START:STYLES_START])
        self.styles_changed = self.colours_changed or not np.array_equal(row[STYLES_START:], last[STYLES_START:])
        last[:] = row
        camera = camera_from_row(row)
        if self.camera_changed and math.dist(camera.eye, camera.target) > MIN_TARGET_DISTANCE:
            self._set_camera(camera)
        self._set_light(row)
        self._spots_changed = True

    @property
    def height(self) -> float:
        """Height of the whole picture [pixels]: lines, circles and ways in it are in proportion to that."""
        return self.part.whole[1]

    @property
    def row(self) -> Float64:
        """The parameter row of the last written frame."""
        return self._row

    @property
    def spots_lit(self) -> bool:
        """Whether any follow spot is lit."""
        return bool(self._data["spot_light"][0, 3] > 0.0)

    @property
    def side_lamps_lit(self) -> bool:
        """Whether the lamps at the sides or straight behind are lit."""
        return bool(self._row[_SIDE] > 0.0 or self._row[_BACK] > 0.0)

    @property
    def beams_lit(self) -> bool:
        """Whether the beams light the floor."""
        return bool(self._row[_BEAMS] > 0.0)

    @property
    def gobos_lit(self) -> bool:
        """Whether the key light has a pattern."""
        return bool(self._row[_GOBOS].any())

    @property
    def light_moves(self) -> bool:
        """Whether the light on dancers has a gobo, or comes up from water."""
        return self.gobos_lit or self.worlds["water"] > 0.0

    @property
    def floor_patterned(self) -> bool:
        """Whether the floor shows gobos or patterns."""
        return self.gobos_lit or bool(self._row[_FLOOR_PATTERNS].any())

    @property
    def rippled(self) -> bool:
        """Whether rings that spread from the dancers' steps are seen: in water or as light on the floor."""
        return rings_are_seen(self._row)

    @property
    def open_air(self) -> bool:
        """Whether a world is seen that no wall ends, so that the floor reaches the horizon."""
        return any(self.worlds[name] > 0.0 for name in ("constellation", "water", "dusk"))

    @property
    def stage_resized(self) -> bool:
        """Whether the stage size differs from the scene's, so that its border may be visible."""
        return bool(self._data["edge"][2] > 0.0)

    @property
    def shadows(self) -> bool:
        """Whether dancers cast shadows."""
        return bool(self._row[SHADOW] > 0.0)

    @property
    def mirrors(self) -> bool:
        """Whether the floor mirrors the dancers."""
        return bool(self._row[MIRROR] > 0.0)

    @property
    def group_colours(self) -> Float64:
        """Colours of the groups in the last written frame, shape (16, 3)."""
        return self._row[COLOURS_START:STYLES_START].reshape(-1, 3)

    @property
    def level(self) -> float:
        """Light level of the last written frame."""
        return float(self._data["key_light"][3])

    def release(self) -> None:
        """Free the buffers."""
        self._buffer.release()
        self._numbers_buffer.release()
