"""Render pass for background images and videos: on the wall behind the stage, or over the whole picture."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import moderngl

from live.base.picture_parameters import BY_ADDRESS, MAX_BACKGROUNDS
from live.base.stage_snapshot import Background, StageView
from live.render.media_background import Picture, Video, is_video, read_image
from live.render.pass_context import Moment, PassSetup, ScenePass
from live.render.shader import compile_program, release_all, set_uniform
from live.render.uniforms import WALL_DISTANCE

_ROWS: Final = tuple(BY_ADDRESS[f"/dance/background/{number}"].first for number in range(1, MAX_BACKGROUNDS + 1))
_WALL_WIDTH: Final = 1.5
"""Default width of a picture on the wall, in stage widths."""


@dataclass(slots=True, eq=False)
class _Source:
    """One background: its settings, texture and video decoder, if it is a video."""

    settings: Background
    texture: moderngl.Texture
    video: Video | None


class BackgroundPass(ScenePass):
    """Draws the backgrounds; costs nothing while none is visible. Videos follow the show's time or beat."""

    def __init__(self, making: PassSetup) -> None:
        """Raises PersonError for a file that cannot be decoded."""
        self._ctx, self._size = making.ctx, making.size
        self.stage_size = making.scene.stage_size
        """Width and depth of the stage [m]."""
        self._program = compile_program(making.ctx, "background_vertex.glsl", "background_fragment.glsl")
        self._quad = making.ctx.vertex_array(self._program, [])
        self._sources = [
            self._open(said, making.blocking_video) if said.file else None for said in making.scene.backgrounds
        ]

    def _open(self, said: Background, patient: bool) -> _Source:
        path = Path(said.file)
        video = Video(path, blocking=patient) if is_video(path) else None
        picture = None if video is not None else read_image(path)
        size = video.size if picture is None else (picture.shape[1], picture.shape[0])  # type: ignore[union-attr]
        texture = self._ctx.texture(size, 3, alignment=1)
        texture.filter = (moderngl.LINEAR_MIPMAP_LINEAR if picture is not None else moderngl.LINEAR, moderngl.LINEAR)
        texture.repeat_x = texture.repeat_y = False
        if picture is not None:
            _upload(texture, picture)
            texture.build_mipmaps()
        else:
            texture.write(bytes(3 * size[0] * size[1]), alignment=1)
        return _Source(said, texture, video)

    def active(self, moment: Moment) -> bool:
        """Whether any background is visible."""
        return any(self._visible_sources(moment))

    def _visible_sources(self, moment: Moment) -> Iterator[tuple[_Source, float]]:
        """Yield the visible backgrounds and their opacity."""
        for place, source in zip(_ROWS, self._sources, strict=False):
            amount = moment.parameter(place)
            if source is not None and amount > 0.0:
                yield source, amount

    @property
    def problems(self) -> list[str]:
        """Errors of videos; their last frames stay visible."""
        videos = [(Path(one.settings.file).name, one.video) for one in self._sources if one is not None and one.video]
        return [f"background {name}: {video.problem}" for name, video in videos if video.problem]

    def light_active(self, moment: Moment) -> bool:
        """The same as `active`: called only then."""
        return True

    def prepare(self, moment: Moment) -> None:
        """Upload the due video frames."""
        for source, _ in self._visible_sources(moment):
            if source.video is None:
                continue
            picture = source.video.picture_at(video_position(moment.view, source.settings.beats, source.video.seconds))
            if picture is not None:
                _upload(source.texture, picture)

    def draw_light(self, moment: Moment) -> None:
        """Draw the visible backgrounds behind the dancers, in order."""
        ctx = self._ctx
        ctx.enable(moderngl.DEPTH_TEST | moderngl.BLEND)
        ctx.disable(moderngl.CULL_FACE)
        ctx.depth_func = "<="
        ctx.blend_func = moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA
        set_uniform(self._program, "shown_texture", 1)
        for source, amount in self._visible_sources(moment):
            self._draw(source, amount)
        ctx.depth_func = "<"
        ctx.disable(moderngl.BLEND)

    def _draw(self, source: _Source, amount: float) -> None:
        aspect = source.texture.width / source.texture.height
        source.texture.use(1)
        set_uniform(self._program, "amount", amount)
        set_uniform(self._program, "brightness", source.settings.brightness)
        if source.settings.fit == "picture":
            own = self._size[0] / self._size[1]
            crop = (min(own / aspect, 1.0), min(aspect / own, 1.0))
            set_uniform(self._program, "wall", (0.0, 0.0, 0.0, 0.0))
            set_uniform(self._program, "crop", crop)
            set_uniform(self._program, "mirrored", 0)
            self._quad.render(moderngl.TRIANGLE_STRIP, vertices=4)
            return
        width = source.settings.width or _WALL_WIDTH * self.stage_size[0]
        depth = -0.5 * self.stage_size[1] - WALL_DISTANCE + 0.02
        set_uniform(self._program, "wall", (0.5 * width, source.settings.bottom, width / aspect, depth))
        set_uniform(self._program, "crop", (1.0, 1.0))
        for mirrored in (0, 1):
            set_uniform(self._program, "mirrored", mirrored)
            self._quad.render(moderngl.TRIANGLE_STRIP, vertices=4)

    def resize(self, size: tuple[int, int]) -> None:
        """New size of the picture [pixels]."""
        self._size = size

    def release(self) -> None:
        """Free everything, and end the threads of videos."""
        for source in self._sources:
            if source is None:
                continue
            if source.video is not None:
                source.video.close()
            source.texture.release()
        release_all(self._quad, self._program)


def video_position(view: StageView, beats: float | None, seconds: float) -> float:
    """Return the position [s] in a looping video of `seconds` length; with `beats`, one loop takes that many beats."""
    return (view.beat / beats) % 1.0 * seconds if beats else view.time % seconds


def _upload(texture: moderngl.Texture, picture: Picture) -> None:
    texture.write(picture.tobytes(), alignment=1)
