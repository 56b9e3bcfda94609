"""The colour grade: lift, gamma and gain of each colour, contrast and temperature."""

from typing import Final

import moderngl
import numpy as np

from live.base.picture import BY_ADDRESS
from live.render.full import Full
from live.render.pass_context import Making, Moment, Surfaces

_ROOT: Final = "/dance/pass/grade"
_AMOUNT: Final = BY_ADDRESS[_ROOT].first
_COLOURS: Final = {name: BY_ADDRESS[f"{_ROOT}/{name}"] for name in ("lift", "gamma", "gain")}
_NUMBERS: Final = {name: BY_ADDRESS[f"{_ROOT}/{name}"] for name in ("contrast", "temperature")}
_PLACES: Final = np.concatenate(
    [np.arange(p.first, p.first + p.size) for p in (*_COLOURS.values(), *_NUMBERS.values())]
)
_NEUTRAL: Final = np.concatenate([p.start for p in (*_COLOURS.values(), *_NUMBERS.values())])


class GradePass:
    """Neutral values change nothing and cost nothing."""

    needs_surfaces = False

    def __init__(self, making: Making) -> None:
        self._full = Full(making.ctx, "grade_fragment.glsl")

    def active(self, moment: Moment) -> bool:
        """While its amount is not 0 and anything is not neutral."""
        return moment.amount(_AMOUNT) > 0.0 and not np.array_equal(moment.frame.row[_PLACES], _NEUTRAL)

    def draw(
        self, source: moderngl.Texture, target: moderngl.Framebuffer, surfaces: Surfaces | None, moment: Moment
    ) -> None:
        """Draw `source` graded."""
        full, row = self._full, moment.frame.row
        full.set("amount", moment.amount(_AMOUNT))
        for name, known in _COLOURS.items():
            full.set(name, tuple(row[known.where].tolist()))
        for name, known in _NUMBERS.items():
            full.set(name, float(row[known.first]))
        full.draw(target, light=source)

    def resize(self, size: tuple[int, int]) -> None:
        """Nothing here has a size."""

    def release(self) -> None:
        """Free the program."""
        self._full.release()
