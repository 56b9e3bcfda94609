"""Size of the picture that outputs need, and the part of it that has to be drawn for them.

A process whose outputs show only a part of the picture draws that part with a border, so that passes which look beside
a pixel find there what the whole picture would have. The border follows from the passes that the show has: none is
resized while their amounts change. What needs more than a border makes it draw the whole picture.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Final

from live.base.arrays import Float64
from live.base.stage_snapshot import Scene
from live.render.camera import PicturePart, Size
from live.render.outputs.output import FULL_CROP, MAX_PICTURE_SIDE, Output
from live.render.passes.bloom_pass import BloomPass
from live.render.passes.blur_pass import BlurPass
from live.render.passes.custom_pass import reads_elsewhere
from live.render.passes.focus_pass import FocusPass
from live.render.passes.ink_pass import InkPass
from live.render.passes.trail_pass import TrailsPass
from live.render.worlds.paper_pass import PaperPass

MAX_SIDE: Final = 8192
"""Maximum side length of what is drawn [pixels]."""
GRID: Final = 96
"""Parts begin and end on multiples of this [pixels]: so smaller textures and tiles of passes (quarters; thirds and
halves in tiles of 8 and 16) lie as in the whole picture."""
WORTH: Final = 0.9
"""A part that covers more than this share of the picture is not worth it: the whole picture is drawn."""
SCENE_REACH: Final = 1.0 / 24.0
"""How far the scene looks beside a pixel: smoothed edges, blurred mirror images, waves that bend what is seen, and
points of light whose middle is outside [heights of the picture]."""

Reach = Callable[[float, Float64], float]
"""How far from a pixel a pass looks: of the picture's height [pixels] and its parameter row."""


def _nowhere(height: float, row: Float64) -> float:
    return 0.0


PASS_REACH: Final[Mapping[str, Reach]] = {
    "focus": FocusPass.reach, "blur": BlurPass.reach, "trails": TrailsPass.reach, "bloom": BloomPass.reach,
    "ink": InkPass.reach, "grade": _nowhere, "vignette": _nowhere, "shadow": _nowhere, "mirror": _nowhere,
}  # fmt: skip
"""Of each pass of `[picture] passes`; shadows are drawn on the floor, and mirror images belong to the scene."""


def picture_reach(scene: Scene, height: float, row: Float64) -> float:
    """Return how far from a pixel all passes look together in a whole picture of this height [pixels]; infinite if one
    needs the whole picture, see `whole_picture_reason`."""
    if whole_picture_reason(scene, row):
        return math.inf
    passes = (PASS_REACH[name](height, row) for name in scene.passes if name in PASS_REACH)
    return SCENE_REACH * height + PaperPass.reach(height, row) + sum(passes)


def whole_picture_reason(scene: Scene, row: Float64) -> str:
    """Return what needs the whole picture, in words; empty if nothing does."""
    for one in scene.custom_passes:
        if one.name in scene.passes and reads_elsewhere(one):
            return f"the pass {one.name} looks at other places of the picture"
    if "trails" in scene.passes and math.isinf(TrailsPass.reach(1.0, row)):
        return "trails grow out of its middle"
    return ""


def shown_share(outputs: Sequence[Output]) -> float:
    """Return the area of the rectangle around all crops, as a share of the picture."""
    sides = (
        max(one.crop[axis] + one.crop[2 + axis] for one in outputs) - min(one.crop[axis] for one in outputs)
        for axis in range(2)
    )
    return math.prod(sides)


def picture_size(
    outputs: Sequence[Output], windows: Sequence[Size], *, asked: Size | None = None, most: int = MAX_SIDE
) -> Size:
    """Return the frame size [pixels] at which no output has to be enlarged, or the size `asked`, smaller if a side is
    longer than `most`; `windows`: window size of each output."""
    sides = [1.0, 1.0] if asked is None else [float(asked[0]), float(asked[1])]
    for output, (width, height) in zip(outputs, windows, strict=True) if asked is None else ():
        upright = (width, height) if output.rotation in (0, 180) else (height, width)
        for axis in range(2):
            sides[axis] = max(sides[axis], upright[axis] / output.crop[2 + axis])
    if asked is None and len(outputs) == 1 and outputs[0].crop == FULL_CROP:
        return round(sides[0]), round(sides[1])
    share = min(1.0, most / max(sides))
    return max(math.ceil(sides[0] * share - 1e-6), 1), max(math.ceil(sides[1] * share - 1e-6), 1)


def drawn_part(
    outputs: Sequence[Output],
    windows: Sequence[Size],
    reach: Callable[[float], float],
    *,
    asked: Size | None = None,
) -> PicturePart:
    """Return the part of the picture to draw for outputs in windows of these sizes, or the whole picture.

    `reach`: how far from a pixel passes look in a picture of this height [pixels]; `asked`: size of the whole picture.
    The part is at most `MAX_SIDE` long; a larger one gets fewer pixels.
    """
    whole = picture_size(outputs, windows, asked=asked, most=MAX_PICTURE_SIDE)
    for _ in range(4):
        part = _part_of(outputs, whole, reach(whole[1]))
        longest = max(part.size)
        if longest <= MAX_SIDE:
            break
        share = (MAX_SIDE - 2 * GRID) / longest
        whole = max(math.ceil(whole[0] * share), 1), max(math.ceil(whole[1] * share), 1)
    share_drawn = part.share[0] * part.share[1]
    if share_drawn <= WORTH and longest <= MAX_SIDE:
        return part
    return PicturePart.of(picture_size(outputs, windows, asked=asked))


def _part_of(outputs: Sequence[Output], whole: Size, reach: float) -> PicturePart:
    """Return the rectangle around all crops with a border of `reach` [pixels], on the grid, within the picture."""
    if math.isinf(reach):
        return PicturePart.of(whole)
    starts, sizes = [], []
    for axis in range(2):
        side = whole[axis]
        low = min(output.crop[axis] for output in outputs) * side - reach
        high = max(output.crop[axis] + output.crop[2 + axis] for output in outputs) * side + reach
        if axis == 1:  # crops are measured from above
            low, high = side - high, side - low
        start = max(math.floor(low / GRID) * GRID, 0)
        starts.append(start)
        sizes.append(min(math.ceil(high / GRID) * GRID, side) - start)
    return PicturePart(whole, starts[0], starts[1], (sizes[0], sizes[1]))
