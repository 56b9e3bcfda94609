"""Draw the gallery of docs/how-to/picture/styles.md: `python tools/draw_styles.py [FOLDER]`.

It dances a few measures to do so.
"""

import copy
import sys
from dataclasses import replace
from pathlib import Path

from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from live.base.arrays import Float64
from live.base.picture_parameters import BY_ADDRESS, STYLE_ADDRESS_PREFIX, group_parameter, picture_row
from live.base.stage_snapshot import Camera, Scene, StageView
from live.clock.ticks import TICK
from live.render.adaptive_quality import SOFTWARE
from live.render.headless import OffscreenTarget, create_headless_context
from live.render.renderer import Renderer
from live.show.loader import load_from_patch
from live.show.patch.patch_reader import parse_patch
from live.show.patch.patch_search_path import PATCHES
from live.show.view.render_scene import make_scene

PATCH = """
name = "styles"
seed = 5
reserve = 0
[stage]
width = 9
depth = 5
[[group]]
name = "ember"
dancers = 3
colour = [0.92, 0.36, 0.14]
steps = ["side step", "reach", "arm wave", "mambo"]
formation = "line"
centre = [0.0, 0.5]
size = [3.8, 1.0]
[[group]]
name = "tide"
dancers = 2
colour = [0.12, 0.52, 0.72]
steps = ["side step", "reach", "arm wave", "mambo"]
formation = "line"
centre = [0.0, -0.9]
size = [2.0, 1.0]
"""
BODIES = ("dancer", "strong", "slim", "round", "dancer")
TILE = (640, 360)
SIZE = (1280, 720)
"""Drawn so large and brought down, for smooth edges."""
SECONDS = 11.2
WATCHED = 2.5
"""Seconds that are drawn, so that what leaves a trace has left it."""
TILES: tuple[dict[str, float], ...] = (
    {"solid": 1.0},
    {"solid": 0.0, "silhouette": 1.0},
    {"solid": 0.0, "ink": 1.0},
    {"solid": 0.0, "particles": 1.0},
    {"solid": 1.0, "ribbons": 1.0, "ribbons/beats": 3.0},
    {"solid": 1.0, "trails": 1.0},
    {"solid": 0.0, "xray": 1.0},
    {"solid": 0.45, "particles": 0.5, "ribbons": 0.7},
)


def row_of(scene: Scene, said: dict[str, float]) -> Float64:
    """The picture's row in which all groups are drawn so; silhouettes and ink before black."""
    row = picture_row(scene)
    for group in range(16):
        for name, value in said.items():
            row[group_parameter(STYLE_ADDRESS_PREFIX + name, group).row_slice] = value
    if said.get("silhouette"):
        for address in ("/dance/light/background", "/dance/light/floor", "/dance/light/rim", "/dance/pass/mirror"):
            row[BY_ADDRESS[address].row_slice] = 0.0
    return row


def moments() -> tuple[Scene, list[StageView]]:
    """What is danced in the last `WATCHED` seconds, and a scene whose camera has all of it in the middle."""
    show = load_from_patch(parse_patch(PATCH, "styles"), PATCHES / "styles.toml").start()
    kept, last = [], round(SECONDS / TICK)
    for tick in range(1, last + 1):
        show.tick(tick * TICK)
        if tick >= last - WATCHED / TICK and (tick == last or tick % 4 == 0):
            view = show.view()
            show.fill(view, show.time)
            kept.append(copy.deepcopy(view))
    here = kept[-1].joint_position[kept[-1].present, 0]
    middle = 0.5 * (here.min(axis=0) + here.max(axis=0))
    x, z = float(middle[0]), float(middle[2])
    camera = Camera((x + 0.3, 1.75, z + 7.6), (x, 0.95, z), 24.0)
    return replace(make_scene(show.patch), camera=camera, bodies=BODIES), kept


def main(folder: Path) -> None:
    """Dance once, and draw the same moment in all styles."""
    scene, kept = moments()
    ctx = create_headless_context()
    renderer, target = Renderer(ctx, scene, size=SIZE, quality=SOFTWARE), OffscreenTarget(ctx, SIZE)
    sheet = Image.new("RGB", (2 * TILE[0], len(TILES) // 2 * TILE[1]))
    dark = copy.deepcopy(kept[0])
    dark.brightness = 0.0
    for tile, said in enumerate(TILES):
        renderer.draw(dark, target.framebuffer)  # of the tile before nothing is left
        for view in kept if "ribbons" in said or "trails" in said else kept[-1:]:
            view.picture = row_of(scene, said)
            renderer.draw(view, target.framebuffer)
        picture = Image.fromarray(target.read()).resize(TILE, Image.Resampling.BOX)
        sheet.paste(picture, (tile % 2 * TILE[0], tile // 2 * TILE[1]))
    folder.mkdir(parents=True, exist_ok=True)
    sheet.save(folder / "styles.jpg", quality=86)


if __name__ == "__main__":
    main(
        Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parents[1] / "docs" / "pictures" / "styles"
    )
