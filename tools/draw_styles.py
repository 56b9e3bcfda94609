"""Draw the gallery of docs/styles.md: `python tools/draw_styles.py [FOLDER]`. It dances the first show to do so."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from bench._show import crowd
from live.base.bodies import BODIES
from live.base.picture import BY_ADDRESS, STYLE_OF_GROUP, Float64, of_group, picture_of
from live.base.stage_view import Camera, Scene
from live.clock.ticks import TICK
from live.render.headless import OffscreenTarget, create_headless_context
from live.render.quality import SOFTWARE
from live.render.renderer import Renderer
from live.show.load import load_show
from live.show.patch_file import DEFAULT_PATCH
from live.show.scene_of import scene_of

SIZE = (640, 360)
DANCERS = 9
SECONDS = 13.0
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
    row = picture_of(scene)
    for group in range(16):
        for name, value in said.items():
            row[of_group(STYLE_OF_GROUP + name, group).where] = value
    if said.get("silhouette"):
        for address in ("/dance/light/background", "/dance/light/floor", "/dance/light/rim", "/dance/pass/mirror"):
            row[BY_ADDRESS[address].where] = 0.0
    return row


def main(folder: Path) -> None:
    """Dance once, and draw each moment in all styles."""
    loaded = load_show(DEFAULT_PATCH)
    show = crowd(DANCERS, loaded)
    ctx = create_headless_context()
    chance = np.random.default_rng(4)
    camera = Camera((0.6, 1.9, 8.2), (0.0, 0.95, 0.0), 34.0)
    bodies = tuple(BODIES[index] for index in chance.integers(len(BODIES), size=DANCERS).tolist())
    scene = replace(scene_of(show.patch), camera=camera, bodies=bodies)
    renderers = [Renderer(ctx, scene, size=SIZE, quality=SOFTWARE) for _ in TILES]
    target, view = OffscreenTarget(ctx, SIZE), show.view()
    sheet = Image.new("RGB", (2 * SIZE[0], len(TILES) // 2 * SIZE[1]))
    last = round(SECONDS / TICK)
    for tick in range(1, last + 1):
        show.tick(tick * TICK)
        if tick < last - WATCHED / TICK or (tick != last and tick % 4):
            continue
        show.fill(view, show.time)
        for tile, (renderer, said) in enumerate(zip(renderers, TILES, strict=True)):
            if tick == last or "ribbons" in said or "trails" in said:
                view.picture = row_of(scene, said)
                renderer.draw(view, target.framebuffer)
            if tick == last:
                sheet.paste(Image.fromarray(target.read()), (tile % 2 * SIZE[0], tile // 2 * SIZE[1]))
    folder.mkdir(parents=True, exist_ok=True)
    sheet.save(folder / "styles.jpg", quality=86)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parents[1] / "docs" / "styles")
