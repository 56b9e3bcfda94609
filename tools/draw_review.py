"""Draw 24 pictures of a show to be judged: `python tools/draw_review.py SHOW [WORLD] [--out FOLDER]`.

Eight moments, spread evenly over the show, are drawn from near (a face, a half figure), from the middle (a whole
figure, a group) and from far (everybody, also from above), each time another dancer from another side. `--director`
draws the director's pictures of the same moments instead. They come as a folder of pictures, and as one sheet, four
pictures wide: near, middle, far.
"""

import argparse
import contextlib
import math
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import numpy as np
from PIL import Image, ImageDraw, ImageFont

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from bench._locomotion_run import engine_of
from live.app.film.show_film import make_renderer
from live.app.launch_options import LaunchOptions
from live.base.arrays import Bool, Float64
from live.base.parameter import WORLD_NAMES
from live.base.picture_parameters import EYE, FIELD_OF_VIEW, ROLL, TARGET
from live.base.stage_snapshot import StageView
from live.control.events.scenes import RecallWorld
from live.motion.skeleton import SKELETON
from live.show.desk.camera_framing import Framing
from live.show.desk.camera_kernels import keep_clear
from live.show.desk.camera_shots import FULL, GROUP, HIGH, SHOULDERS, TOTAL, WAIST, ShotKind
from live.show.loader import load_show
from live.show.patch.patch_search_path import find_patch

SIZE: Final = (960, 540)
TILE: Final = (480, 270)
MOMENTS: Final = 8
UNSAID_MEASURES: Final = 32
"""So much is looked at of a show without a length."""
LEAD_IN_S: Final = 0.75
LEAD_IN_FPS: Final = 8
SHOTS: Final[dict[str, tuple[ShotKind, ShotKind]]] = {
    "near": (SHOULDERS, WAIST), "middle": (FULL, GROUP), "far": (TOTAL, HIGH),
}  # fmt: skip
"""Two kinds of shots for each distance, in turns."""
BEARINGS_DEG: Final[dict[str, tuple[float, ...]]] = {
    "near": (0, 35, -30, 80, 20, -65, 45, -10),  # from where the dancer faces
    "middle": (0, -30, 40, 15, -50, 25, -10, 60),  # from the public's side
    "far": (0, 10, -30, 0, 30, -15, -45, 20),
}
SIDES: Final = [SKELETON.names.index(name) for name in ("leftUpperArm", "rightUpperArm")]


def headings(view: StageView) -> Float64:
    """Where chests face [rad], (A,): across the line from shoulder to shoulder."""
    across = view.joint_position[:, SIDES[0]] - view.joint_position[:, SIDES[1]]
    return np.asarray(np.arctan2(-across[:, 2], across[:, 0]), np.float64)


def point_camera(view: StageView, present: Bool, framing: Framing, distance: str, moment: int) -> None:
    """Write the camera of a distance into the view's row."""
    kind = SHOTS[distance][moment % 2]
    place = np.ascontiguousarray(view.joint_position[:, 0, ::2], np.float64)
    there = present & np.isfinite(place).all(axis=1)
    rows = np.flatnonzero(there)
    chosen = there.copy()
    bearing = math.radians(BEARINGS_DEG[distance][moment])
    if kind.subject != "all" and len(rows):
        one = int(rows[(moment * 5 + (2 if distance == "middle" else 0)) % len(rows)])
        chosen[:] = False
        chosen[one] = True
        if kind is GROUP:
            chosen[rows[np.argsort(np.hypot(*(place[rows] - place[one]).T))[:4]]] = True
        if distance == "near":
            bearing += float(headings(view)[one])
    elevation = math.radians(45.0 if kind is HIGH else 14.0 if kind is TOTAL else 5.0)
    frame = framing.fit(kind, place, chosen, bearing, elevation)
    eye = frame.eye
    keep_clear(eye, np.nan_to_num(place), there, 0.8, 0.3)
    row = view.picture
    assert row is not None
    row[EYE], row[TARGET], row[FIELD_OF_VIEW] = eye, frame.target, frame.field_of_view
    row[ROLL : ROLL + 5] = 0.0, 0.0, 0.0, 1.0, 0.0


def pictures(name: str, world: str | None, distances: list[str]) -> Iterator[tuple[str, int, float, Image.Image]]:
    """Yield distance, moment, measure and picture, moment by moment."""
    loaded = load_show(find_patch(name))
    clock_of = loaded.patch.clock
    measures = loaded.patch.loop_measures or UNSAID_MEASURES
    show = loaded.start(tempo=clock_of.bpm)
    engine, clock, inbox = engine_of(show)
    engine.view.detailed = True
    if world is not None:
        inbox.put(RecallWorld(time=0.0, source="osc", name=world, measures=0.0))
    framing = Framing(SIZE[0] / SIZE[1], 0.5 * np.array([loaded.patch.stage.width, loaded.patch.stage.depth]))
    with contextlib.ExitStack() as stack:
        target, renderer = make_renderer(stack, LaunchOptions(size=SIZE), loaded, fine=True)
        for moment in range(MOMENTS):
            measure = 1.0 + (moment + 0.55 + 0.05 * moment) * measures / (MOMENTS + 0.5)
            end = (measure - 1.0) * clock_of.beats_per_measure * 60.0 / clock_of.bpm
            for frame in range(-math.ceil(min(LEAD_IN_S, end) * LEAD_IN_FPS), 1):
                clock.set(end + frame / LEAD_IN_FPS)
                engine.frame(lambda _: None)
                renderer.draw(engine.view, target.framebuffer)
            if "director" in distances:
                yield "director", moment, measure, Image.fromarray(target.read()).convert("RGB")
            for distance in distances:
                if distance in SHOTS:
                    point_camera(engine.view, show.motion.present, framing, distance, moment)
                    renderer.draw(engine.view, target.framebuffer)
                    yield distance, moment, measure, Image.fromarray(target.read()).convert("RGB")


def main() -> None:
    """Draw a sheet."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("show", help="a patch")
    parser.add_argument("world", nargs="?", choices=WORLD_NAMES, help="another world than the patch's")
    parser.add_argument("--director", action="store_true", help="the director's pictures instead")
    parser.add_argument("--out", type=Path, default=Path("."), help="the folder of the sheet")
    said = parser.parse_args()
    distances = ["director"] if said.director else list(SHOTS)
    sheet = Image.new("RGB", (4 * TILE[0], 2 * len(distances) * TILE[1]), (17, 18, 21))
    pen, font = ImageDraw.Draw(sheet), ImageFont.load_default(13)
    words = [said.show, *([said.world] if said.world else []), *(["director"] if said.director else [])]
    name = "-".join(words)
    (said.out / name).mkdir(parents=True, exist_ok=True)
    for distance, moment, measure, picture in pictures(said.show, said.world, distances):
        x, y = moment % 4 * TILE[0], (2 * distances.index(distance) + moment // 4) * TILE[1]
        picture.save(said.out / name / f"{distance}-{moment + 1}.png")
        sheet.paste(picture.resize(TILE, Image.Resampling.LANCZOS), (x, y))
        pen.text(
            (x + 4, y + 3), f"{measure:.1f}", fill=(230, 230, 230), font=font, stroke_width=1, stroke_fill=(0, 0, 0)
        )
    sheet.save(said.out / f"{name}.png")


if __name__ == "__main__":
    main()
