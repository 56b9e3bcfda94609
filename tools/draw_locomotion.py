"""Pictures of the scenes of `live bench locomotion`: ``python tools/draw_locomotion.py plan|film SCENE FILE``.

``plan``: the floor from above over some measures, as the engine dances the scene and in the two naive ways: lines are
the ways of hips, dots the places of feet that stand (a foot that slides draws a streak). ``film``: an MP4, or, with
a name that ends in .jpg, a sheet of stills, four to a beat.
"""

import argparse
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from bench._locomotion_libraries import load_library
from bench._locomotion_run import ENGINE, FPS, SLIDING, UNCORRECTED, dance
from bench._locomotion_scenes import DEPTH, SCENES, WIDTH, Take, stage
from live.base.stage_snapshot import StageView
from live.motion.editing.foot_correction import BALLS
from live.show.show import Show

SCALE: Final = 100
"""Pixels a metre, before the picture is made half as large."""
GROUND: Final = (18, 19, 26)
PAPER: Final = (246, 244, 238)
SHEET_COLUMNS: Final = 4


class Trail:
    """Hips and standing feet of everybody from `begin` to `end` [s]."""

    def __init__(self, begin: float, end: float) -> None:
        self._begin, self._end = begin, end
        self.hips: list[npt.NDArray[np.float32]] = []
        self.feet: list[npt.NDArray[np.float32]] = []
        self.contact: list[npt.NDArray[np.bool_]] = []

    def __call__(self, show: Show, view: StageView) -> None:
        """Keep one picture."""
        if self._begin <= view.time < self._end:
            self.hips.append(view.joint_position[:, 0][:, (0, 2)].copy())
            self.feet.append(view.joint_position[:, BALLS][..., (0, 2)].copy())
            self.contact.append(show.dancers.contact(show.span.fraction(view.beat)))

    def draw(self) -> Image.Image:
        """The floor from above, the audience below."""
        picture = Image.new("RGB", (int((WIDTH + 0.6) * SCALE), int((DEPTH + 0.6) * SCALE)), PAPER)
        canvas = ImageDraw.Draw(picture)
        canvas.rectangle(
            (0.3 * SCALE, 0.3 * SCALE, (WIDTH + 0.3) * SCALE, (DEPTH + 0.3) * SCALE), outline=(150, 148, 140)
        )
        hips, feet, contact = np.stack(self.hips), np.stack(self.feet), np.stack(self.contact)
        for dancer in range(hips.shape[1]):
            way = [self._at(place) for place in hips[:, dancer]]
            canvas.line(way, fill=(176, 172, 160), width=3)
            for foot, colour in ((0, (214, 96, 30)), (1, (24, 108, 168))):
                for place in feet[contact[:, dancer, foot], dancer, foot]:
                    x, y = self._at(place)
                    canvas.ellipse((x - 5, y - 5, x + 5, y + 5), fill=colour)
            x, y = way[-1]
            canvas.ellipse((x - 25, y - 25, x + 25, y + 25), outline=(90, 88, 82), width=3)
        return picture.resize((picture.width // 2, picture.height // 2), Image.Resampling.LANCZOS)

    @staticmethod
    def _at(place: npt.NDArray[np.float32]) -> tuple[float, float]:
        return (float(place[0]) + WIDTH / 2 + 0.3) * SCALE, (float(place[1]) + DEPTH / 2 + 0.3) * SCALE


def recorded(folder: Path | None) -> dict[str, Any]:
    """Return the patch and graph of a library of recordings, for `dance`; without a folder it dances the sketches."""
    if folder is None:
        return {}
    loaded = load_library(folder)
    return {"patch": loaded.patch, "graph": loaded.graph}


def plan(scene: str, file: Path, begin: float, end: float, steps: Path | None) -> None:
    """One floor beside the other: the engine, sliding, uncorrected."""
    floors = []
    for way in (ENGINE, SLIDING, UNCORRECTED):
        trail = Trail(begin, end)
        dance(Take(scene, 1, end), way, watch=trail, **recorded(steps))
        floors.append(trail.draw())
    sheet = Image.new("RGB", (sum(each.width for each in floors), floors[0].height), PAPER)
    for number, each in enumerate(floors):
        sheet.paste(each, (number * each.width, 0))
    sheet.save(file, quality=88)


def film(asked: argparse.Namespace) -> None:
    """Every so many-th picture of the scene: as a film at its own speed, or side by side."""
    from live.base.stage_snapshot import Camera
    from live.render.headless import OffscreenTarget, create_headless_context
    from live.render.renderer import Renderer
    from live.show.view.render_scene import make_scene

    ctx, size, file, every = create_headless_context(), tuple(asked.size), asked.file, asked.every
    target = OffscreenTarget(ctx, size)
    x, z = asked.look
    camera = Camera((x, 3.0, z + 11.0), (x, 0.8, z), asked.view)
    renderer = Renderer(ctx, replace(make_scene(stage().patch), camera=camera), size=size)
    pictures: list[Image.Image] = []
    count = 0

    def draw(show: Show, view: StageView) -> None:
        nonlocal count
        count += 1
        if view.time < asked.begin or count % every:
            return
        renderer.draw(view, target.framebuffer)
        pictures.append(Image.fromarray(np.array(target.read())))

    dance(Take(asked.scene, 1, asked.end), watch=draw, **recorded(asked.steps))
    if file.suffix == ".mp4":
        _encode(pictures, file, FPS / every)
    else:
        rows = -(-len(pictures) // SHEET_COLUMNS)
        sheet = Image.new("RGB", (SHEET_COLUMNS * size[0], rows * size[1]), GROUND)
        for number, each in enumerate(pictures):
            sheet.paste(each, (number % SHEET_COLUMNS * size[0], number // SHEET_COLUMNS * size[1]))
        sheet.save(file, quality=86)
    renderer.release()


def _encode(pictures: list[Image.Image], file: Path, rate: float) -> None:
    import av

    with av.open(str(file), "w") as container:
        stream = container.add_stream("h264", rate=round(rate))
        stream.width, stream.height = pictures[0].size
        stream.pix_fmt = "yuv420p"
        for picture in pictures:
            for packet in stream.encode(av.VideoFrame.from_ndarray(np.asarray(picture), format="rgb24")):
                container.mux(packet)
        for packet in stream.encode():
            container.mux(packet)


def main() -> None:
    """What is asked for on the command line."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("what", choices=("plan", "film"))
    parser.add_argument("scene", choices=SCENES)
    parser.add_argument("file", type=Path)
    parser.add_argument("--begin", type=float, default=7.0, help="from here [s]")
    parser.add_argument("--end", type=float, default=13.4, help="to here [s]")
    parser.add_argument("--size", type=int, nargs=2, default=(640, 360), help="of one picture [pixels]")
    parser.add_argument("--every", type=int, default=8, help="every so many-th picture of 60 a second")
    parser.add_argument("--look", type=float, nargs=2, default=(0.0, 0.0), help="at this place (x, z) [m]")
    parser.add_argument("--view", type=float, default=34.0, help="vertical field of view [degrees]")
    parser.add_argument("--steps", type=Path, help="a library of recordings to dance instead of sketches")
    asked = parser.parse_args()
    if asked.what == "plan":
        plan(asked.scene, asked.file, asked.begin, asked.end, asked.steps)
    else:
        film(asked)


if __name__ == "__main__":
    main()
