"""Render passes for planes with images, videos and live inputs: behind the dancers, on the floor, and before them."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import moderngl

from live.base.picture_parameters import BY_ADDRESS, MAX_BACKGROUNDS
from live.base.stage_snapshot import Background, StageView
from live.render.media.live_input import LiveInput
from live.render.media.media_files import ImageSequence, Picture, Video, is_sequence, is_video, read_image
from live.render.pass_context import Moment, PassSetup, ScenePass
from live.render.shader import compile_program, release_all, set_uniform
from live.render.uniforms import WALL_DISTANCE

_ROWS: Final = tuple(BY_ADDRESS[f"/dance/background/{number}"].first for number in range(1, MAX_BACKGROUNDS + 1))
_WALL_WIDTH: Final = 1.5
"""Default width of a picture that stands, in stage widths."""
_GAUZE_DISTANCE: Final = 0.3
"""Default distance of a gauze before the stage's front edge [m]."""
_FLOOR_LIFT: Final = 0.004
"""Height of a picture above the floor [m]."""
_PICTURE, _WALL, _FLOOR, _GAUZE = range(4)
_KINDS: Final = {"behind": _WALL, "floor": _FLOOR, "front": _GAUZE}
_Vector = tuple[float, float, float]


@dataclass(slots=True, eq=False)
class _Source:
    """One plane: its number, settings, texture, and decoder if it moves."""

    number: int
    settings: Background
    texture: moderngl.Texture
    stream: Video | ImageSequence | LiveInput | None

    @property
    def name(self) -> str:
        """Its name in messages."""
        return self.settings.input or Path(self.settings.file).name

    @property
    def aspect(self) -> float:
        """Width by height of its picture."""
        return self.texture.width / self.texture.height if self.stream is None else self.stream.aspect


class BackgroundPass(ScenePass):
    """Draws the planes behind the dancers and on the floor; costs nothing while none is visible. Videos follow the
    show's time or beat."""

    PLACES: tuple[str, ...] = ("behind", "floor")
    """Places of the planes that it draws."""

    def __init__(self, making: PassSetup) -> None:
        """Raises PersonError for a file that cannot be decoded."""
        self._ctx = making.ctx
        self._multisampled = making.quality.samples > 0
        self.stage_size = making.scene.stage_size
        """Width and depth of the stage [m]."""
        self._program = compile_program(making.ctx, "background_vertex.glsl", "background_fragment.glsl")
        self._quad = making.ctx.vertex_array(self._program, [])
        self._sources = [
            self._open(number, said, making.blocking_video)
            for number, said in enumerate(making.scene.backgrounds)
            if said.place in self.PLACES and (said.file or said.input)
        ]

    def _open(self, number: int, said: Background, patient: bool) -> _Source:
        path = Path(said.file)
        stream: Video | ImageSequence | LiveInput | None = None
        if said.input:
            stream = LiveInput(said.input)
        elif is_sequence(path):
            stream = ImageSequence(path, said.fps, blocking=patient)
        elif is_video(path):
            stream = Video(path, blocking=patient)
        if stream is not None:
            texture = self._ctx.texture(stream.size, stream.components, alignment=1)
            texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
            texture.write(bytes(stream.components * stream.size[0] * stream.size[1]), alignment=1)
        else:
            picture = read_image(path)
            texture = self._ctx.texture((picture.shape[1], picture.shape[0]), picture.shape[2], alignment=1)
            texture.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
            _upload(texture, picture)
            texture.build_mipmaps()
        if texture.components == 3:
            texture.swizzle = "RGB1"
        texture.repeat_x = texture.repeat_y = False
        return _Source(number, said, texture, stream)

    def active(self, moment: Moment) -> bool:
        """Whether any plane is visible."""
        return any(self._visible_sources(moment))

    def _visible_sources(self, moment: Moment) -> Iterator[tuple[_Source, float]]:
        """Yield the visible planes and their opacity."""
        for source in self._sources:
            amount = moment.parameter(_ROWS[source.number])
            if amount > 0.0:
                yield source, amount

    @property
    def problems(self) -> list[str]:
        """Errors of videos and live inputs; their last pictures stay visible."""
        moving = [(one.name, one.stream) for one in self._sources if one.stream is not None]
        return [f"background {name}: {stream.problem}" for name, stream in moving if stream.problem]

    def light_active(self, moment: Moment) -> bool:
        """The same as `active`: called only then."""
        return True

    def prepare(self, moment: Moment) -> None:
        """Upload the due pictures of videos and live inputs."""
        for source, _ in self._visible_sources(moment):
            if source.stream is None:
                continue
            age = moment.view.background_age[source.number]
            picture = source.stream.picture_at(
                video_position(moment.view, source.settings, source.stream.seconds, (float(age[0]), float(age[1])))
            )
            if picture is not None:
                _upload(source.texture, picture)

    def draw_light(self, moment: Moment) -> None:
        """Draw the visible planes, in order."""
        ctx = self._ctx
        ctx.enable(moderngl.DEPTH_TEST | moderngl.BLEND)
        ctx.disable(moderngl.CULL_FACE)
        target = ctx.fbo
        target.depth_mask, ctx.depth_func = False, "<="
        ctx.blend_func = moderngl.ONE, moderngl.ONE_MINUS_SRC_ALPHA
        moment.floor.use(2)
        set_uniform(self._program, "shown_texture", 1)
        set_uniform(self._program, "floor_map", 2)
        for source, amount in self._visible_sources(moment):
            self._draw(source, amount, moment.uniforms.part.whole)
        target.depth_mask, ctx.depth_func = self._multisampled, "<"
        ctx.disable(moderngl.BLEND)

    def _draw(self, source: _Source, amount: float, size: tuple[float, float]) -> None:
        said, linked, aspect = source.settings, self._program, source.aspect
        source.texture.use(1)
        set_uniform(linked, "amount", amount)
        set_uniform(linked, "brightness", said.brightness)
        set_uniform(linked, "adds", int(said.blend == "add"))
        set_uniform(linked, "mirrored", 0)
        if said.fit == "picture":
            own = size[0] / size[1]
            set_uniform(linked, "kind", _PICTURE)
            set_uniform(linked, "across", (0.0, 0.0, 0.0))
            set_uniform(linked, "depth", -1.0 if said.place == "front" else 1.0)
            set_uniform(linked, "crop", (min(own / aspect, 1.0), min(aspect / own, 1.0)))
            self._quad.render(moderngl.TRIANGLE_STRIP, vertices=4)
            return
        kind = _KINDS[said.place]
        for name, vector in zip(("origin", "across", "down"), plane_of(said, aspect, self.stage_size), strict=True):
            set_uniform(linked, name, vector)
        set_uniform(linked, "kind", kind)
        set_uniform(linked, "grounded", int(kind != _FLOOR and said.bottom <= 0.0))
        set_uniform(linked, "crop", (1.0, 1.0))
        for mirrored in (0, 1) if kind == _WALL else (0,):
            set_uniform(linked, "mirrored", mirrored)
            self._quad.render(moderngl.TRIANGLE_STRIP, vertices=4)

    def release(self) -> None:
        """Free everything, and end the threads of videos and live inputs."""
        for source in self._sources:
            if source.stream is not None:
                source.stream.close()
            source.texture.release()
        release_all(self._quad, self._program)


class FrontPass(BackgroundPass):
    """Draws the planes before the dancers, as gauzes are: over them, and over all light between."""

    PLACES = ("front",)


def plane_of(said: Background, aspect: float, stage_size: tuple[float, float]) -> tuple[_Vector, _Vector, _Vector]:
    """Return the upper left corner of a plane with a picture of this aspect, and the ways to its right and lower edge
    [m]."""
    if said.place == "floor":
        width = said.width or stage_size[0]
        x, z = said.at or (0.0, 0.0)
        cos, sin = math.cos(math.radians(said.turn_deg)), math.sin(math.radians(said.turn_deg))
        across = (width * cos, 0.0, -width * sin)
        down = (width / aspect * sin, 0.0, width / aspect * cos)
        corner = (x - 0.5 * (across[0] + down[0]), _FLOOR_LIFT, z - 0.5 * (across[2] + down[2]))
        return corner, across, down
    width = said.width or _WALL_WIDTH * stage_size[0]
    gauze = said.place == "front"
    usual = 0.5 * stage_size[1] + _GAUZE_DISTANCE if gauze else -0.5 * stage_size[1] - WALL_DISTANCE + 0.02
    x, z = said.at or (0.0, usual)
    high = width / aspect
    return (x - 0.5 * width, said.bottom + high, z), (width, 0.0, 0.0), (0.0, -high, 0.0)


def video_position(view: StageView, said: Background, seconds: float, age: tuple[float, float]) -> float:
    """Return the position [s] in a video of `seconds` length. It loops, in `beats` if the plane says so, or holds its
    end `age` (seconds, beats) after it became visible."""
    if said.end == "hold":
        return min(age[1] / said.beats * seconds if said.beats else age[0], seconds)
    if math.isinf(seconds):
        return 0.0
    return (view.beat / said.beats) % 1.0 * seconds if said.beats else view.time % seconds


def _upload(texture: moderngl.Texture, picture: Picture) -> None:
    texture.write(picture.tobytes(), alignment=1)
