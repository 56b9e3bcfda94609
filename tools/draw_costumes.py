"""Draw the line-up of docs/how-to/picture/costumes.md: `python tools/draw_costumes.py [FOLDER]`.

Every body, costume, pair of shoes and hair style is in it, on dancers who dance a few measures.
"""

import sys
from dataclasses import replace
from pathlib import Path

from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from live.base.picture_parameters import LENS
from live.base.stage_snapshot import Camera
from live.clock.ticks import TICK
from live.render.adaptive_quality import HARDWARE
from live.render.headless import OffscreenTarget, create_headless_context
from live.render.renderer import Renderer
from live.show.desk.scenes import start_row
from live.show.loader import load_from_patch
from live.show.patch.patch_reader import parse_patch
from live.show.patch.patch_search_path import PATCHES
from live.show.view.render_scene import make_scene
from tools.draw_worlds import save

SIZE = (1920, 600)
SECONDS = 3.1
LARGEST = 90_000
"""Maximum size of the picture [bytes]."""
COLOURS = ((0.55, 0.10, 0.09), (0.10, 0.26, 0.38), (0.52, 0.34, 0.10), (0.28, 0.12, 0.30))
LINE = (
    ("dancer", "leotard", "ballet", "bun", 0.7, 0.15),
    ("man", "jacket", "boots", "crop", 0.25, 0.0),
    ("woman", "dress", "pumps", "long", 0.9, 0.45),
    ("strong", "bare", "barefoot", "bald", 0.05, 0.0),
    ("slim", "skirt", "ballet", "ponytail", 0.5, 0.1),
    ("child", "unitard", "sneakers", "braid", 0.85, 0.6),
    ("round", "trousers", "sneakers", "curls", 0.15, 0.05),
    ("older woman", "dress", "pumps", "bob", 0.75, 0.95),
    ("older man", "jacket", "boots", "crop", 0.6, 0.85),
)
"""Body, costume, shoes, hair, tones of skin and hair; every name that there is occurs."""
GAP = 0.86
"""Distance between two dancers [m]."""


def patch_text() -> str:
    """A patch of one group of one dancer for each of `LINE`."""
    groups = []
    middle = 0.5 * (len(LINE) - 1)
    for number, (body, costume, shoes, hair, skin, tone) in enumerate(LINE):
        groups.append(f"""
[[group]]
name = "dancer {number + 1}"
dancers = 1
colour = {list(COLOURS[number % len(COLOURS)])}
bodies = ["{body}"]
steps = ["side step"]
centre = [{GAP * (number - middle)}, 0]
size = [1, 1]
[group.draw]
costume = "{costume}"
shoes = "{shoes}"
hair = "{hair}"
skin = {skin}
skin_variety = 0
hair_tone = {tone}
hair_variety = 0
variety = 0
""")
    return f"""
name = "costumes"
seed = 5
reserve = 0
[stage]
width = {GAP * len(LINE) + 2.0}
depth = 4
[look]
world = "haze"
{"".join(groups)}"""


def main(folder: Path) -> None:
    """Dance, and draw the last moment."""
    patch = parse_patch(patch_text(), "costumes")
    show = load_from_patch(patch, PATCHES / "styles.toml").start()
    for tick in range(1, round(SECONDS / TICK) + 1):
        show.tick(tick * TICK)
    view = show.view()
    show.fill(view, show.time)
    eye, target = (0.2, 1.35, 11.6), (-0.16, 0.88, 0.0)
    scene = replace(make_scene(show.patch), camera=Camera(eye, target, 12.0))
    row = view.picture = start_row(patch)
    row[LENS.start : LENS.start + 7] = *eye, *target, 12.0
    ctx = create_headless_context()
    renderer, drawn = Renderer(ctx, scene, size=SIZE, quality=HARDWARE, warm_up=False), OffscreenTarget(ctx, SIZE)
    for _ in range(2):
        renderer.draw(view, drawn.framebuffer)
    folder.mkdir(parents=True, exist_ok=True)
    picture = Image.fromarray(drawn.read()).resize((1280, 400), Image.Resampling.LANCZOS)
    save(picture, folder / "costumes.jpg", LARGEST)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parents[1] / "docs" / "pictures")
