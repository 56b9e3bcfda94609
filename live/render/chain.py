"""The picture passes in their order: each makes of the picture so far another one, and the film curve ends it."""

from collections.abc import Callable, Mapping, Sequence
from typing import Final

import moderngl

from live.base.custom_pass import OwnPass
from live.render.gl_release import release_all
from live.render.pass_context import HDR, Making, Moment, PicturePass, Surfaces
from live.render.pass_faults import PassFaults
from live.render.passes.bloom_pass import BloomPass
from live.render.passes.custom_pass import OwnPicturePass
from live.render.passes.final_pass import FinalPass
from live.render.passes.grade_pass import GradePass
from live.render.passes.ink_pass import InkPass
from live.render.passes.trails_pass import TrailsPass
from live.render.passes.vignette_pass import VignettePass

PICTURE_PASSES: Final[Mapping[str, Callable[[Making], PicturePass]]] = {
    "trails": TrailsPass,
    "bloom": BloomPass,
    "ink": InkPass,
    "grade": GradePass,
    "vignette": VignettePass,
}
"""Those that can be in `[picture] passes`, by name; `shadow` and `mirror` belong to the scene."""
AT_END: Final = "vignette"
"""As the last one of the order it is done together with the film curve."""


class Chain:
    """All picture passes of a show, those that are active now, and the two textures between them."""

    def __init__(self, making: Making) -> None:
        self._ctx = making.ctx
        order = making.scene.passes
        self.vignette_at_end = order[-1:] == (AT_END,)
        own = {one.name: (one, slot) for slot, one in enumerate(making.scene.own)}
        self._own: dict[str, OwnPicturePass] = {}
        self._passes: list[tuple[str, PicturePass]] = []
        for name in order:
            if name in own:
                self._own[name] = OwnPicturePass(making, *own[name])
                self._passes.append((name, self._own[name]))
            elif name in PICTURE_PASSES and not (name == AT_END and self.vignette_at_end):
                self._passes.append((name, PICTURE_PASSES[name](making)))
        self._names = {one: name for name, one in self._passes}
        self._final = FinalPass(making.ctx)
        self._make(making.size)

    def _make(self, size: tuple[int, int]) -> None:
        count = 2 if self._passes else 0
        self._textures = [self._ctx.texture(size, 4, dtype=HDR) for _ in range(count)]
        for texture in self._textures:
            texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
            texture.repeat_x = texture.repeat_y = False
        self._targets = [self._ctx.framebuffer([texture]) for texture in self._textures]

    def take_own(self, passes: tuple[OwnPass, ...]) -> None:
        """Other texts for own passes; PersonError if one does not compile: its last one goes on."""
        for one in passes:
            there = self._own.get(one.name)
            if there is not None and there.own != one:
                there.take(one)

    def active(self, moment: Moment, left_out: Sequence[str]) -> list[PicturePass]:
        """The passes that change something now, in order, without those that quality leaves out."""
        return [one for name, one in self._passes if name not in left_out and one.active(moment)]

    def has(self, name: str, moment: Moment) -> bool:
        """Whether a pass would change something now, left out or not."""
        return any(one.active(moment) for known, one in self._passes if known == name)

    def draw(
        self,
        active: list[PicturePass],
        source: moderngl.Texture,
        target: moderngl.Framebuffer,
        surfaces: Surfaces | None,
        moment: Moment,
        faults: PassFaults,
    ) -> None:
        """Draw `source`, compressed light, through the passes that are `active` onto `target`; `faults` is told which
        is drawn."""
        self._ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE | moderngl.BLEND)
        last = active[-1] if active else None
        bloom = last if isinstance(last, BloomPass) else None
        turn = 0
        for one in active if bloom is None else active[:-1]:
            faults.may(self._names[one])
            one.draw(source, self._targets[turn], surfaces, moment)
            source, turn = self._textures[turn], 1 - turn
        if bloom is None:
            faults.essential()
            self._final.draw(source, target)
        else:
            faults.may(self._names[bloom])
            gathered, strength = bloom.gather(source), bloom.strength(moment)
            faults.essential()
            self._final.draw(source, target, gathered, strength)

    def resize(self, size: tuple[int, int]) -> None:
        """New size of the picture [pixels]."""
        release_all(*self._targets, *self._textures)
        self._make(size)
        for _, one in self._passes:
            one.resize(size)

    def release(self) -> None:
        """Free everything."""
        release_all(*self._targets, *self._textures, self._final, *(one for _, one in self._passes))
