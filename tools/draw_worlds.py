"""Draw the pictures of docs/how-to/picture/worlds.md: `python tools/draw_worlds.py [FOLDER]`.

It dances a few measures to do so: one picture for each world, and a cross-fade between two.
"""

import copy
import sys
from pathlib import Path

from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from live.base.arrays import Float64
from live.base.parameter import WORLD_NAMES
from live.base.picture_parameters import LENS
from live.base.stage_snapshot import Scene, StageView
from live.render.adaptive_quality import HARDWARE
from live.render.headless import OffscreenTarget, create_headless_context
from live.render.renderer import Renderer
from live.show.desk.scenes import start_row
from live.show.patch.patch_reader import parse_patch
from tools.draw_styles import PATCH, moments

TILE = (640, 360)
SIZE = (1280, 720)
QUALITY = 80
LARGEST = 60_000
"""Maximum size of a picture [bytes]."""
FADE = ("dusk", "water")
SHARES = (0.0, 0.33, 0.67, 1.0)


def row_in(world: str, scene: Scene) -> Float64:
    """The picture's row of the patch in a world, with the scene's camera."""
    row = start_row(parse_patch(f'{PATCH}\n[look]\nworld = "{world}"\n', "worlds"))
    eye, target, angle = scene.camera.eye, scene.camera.target, scene.camera.field_of_view_deg
    row[LENS.start : LENS.start + 7] = *eye, *target, angle
    return row


class Pictures:
    """Draws the last moment of what was danced, after the moments before it: rings on water need them."""

    def __init__(self) -> None:
        self.scene, self._kept = moments()
        ctx = create_headless_context()
        self._renderer = Renderer(ctx, self.scene, size=SIZE, quality=HARDWARE, warm_up=False)
        self._target = OffscreenTarget(ctx, SIZE)

    def draw(self, row: Float64) -> Image.Image:
        """The picture of a row."""
        views: list[StageView] = copy.deepcopy(self._kept[-1::-4][::-1])
        for view in views:
            view.picture = row
            self._renderer.draw(view, self._target.framebuffer)
        return Image.fromarray(self._target.read()).resize(TILE, Image.Resampling.BOX)


def save(picture: Image.Image, path: Path) -> None:
    """Save a picture as small as docs need it."""
    for quality in range(QUALITY, 30, -6):
        picture.save(path, quality=quality, optimize=True)
        if path.stat().st_size <= LARGEST:
            return


def main(folder: Path) -> None:
    """Draw all worlds, and a fade."""
    pictures = Pictures()
    folder.mkdir(parents=True, exist_ok=True)
    for name in WORLD_NAMES:
        save(pictures.draw(row_in(name, pictures.scene)), folder / f"{name}.jpg")
    one, other = (row_in(name, pictures.scene) for name in FADE)
    strip = Image.new("RGB", (TILE[0], TILE[1]))
    size = TILE[0] // 2, TILE[1] // 2
    for place, share in enumerate(SHARES):
        tile = pictures.draw((1.0 - share) * one + share * other).resize(size, Image.Resampling.BOX)
        strip.paste(tile, (place % 2 * size[0], place // 2 * size[1]))
    save(strip, folder / "fade.jpg")


if __name__ == "__main__":
    main(
        Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parents[1] / "docs" / "pictures" / "worlds"
    )
