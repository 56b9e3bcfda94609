"""Draw a step as a strip of stick figures: ``python tools/draw_step.py patches/steps/samba.toml samba.png``.

Upper row from the audience, middle row from the dancer's left, lower row from above. The left side of the body is
orange, the right side blue; a foot on the floor is marked green. With several steps the picture is a sheet of them all,
four figures each: ``python tools/draw_step.py patches/*/steps/*.toml docs/pictures/vocabulary.jpg``.
"""

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from live.motion import quaternion
from live.motion.forward_kinematics import forward_kinematics
from live.motion.mirror import mirror_step
from live.motion.skeleton import SKELETON
from live.motion.sketch.sketch_clips import step_clip
from live.motion.sketch.sketch_file import SketchError, parse_sketch
from live.motion.step_clip import DIRECTIONS, StepClip

Float = npt.NDArray[np.floating]
Bool = npt.NDArray[np.bool_]
View = Callable[[Float], tuple[float, float]]
Canvas = ImageDraw.ImageDraw

CELL: Final = 150
FIGURE: Final = 230
PLAN: Final = 90
PIXELS_PER_METRE: Final = 110.0
COLOURS: Final = {"left": (235, 130, 50), "right": (70, 150, 235)}
MIDDLE: Final = (225, 225, 225)


def main() -> int:
    """Read the arguments, draw, and say where the picture is."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", type=Path, nargs="+", help="a step, e.g. patches/steps/samba.toml, or several")
    parser.add_argument("picture", type=Path, help="where the picture goes (PNG)")
    parser.add_argument("--direction", choices=DIRECTIONS, default="in place")
    parser.add_argument("--mirrored", action="store_true", help="the other side of the body")
    parser.add_argument("--per-beat", type=int, default=4, help="figures a beat (default 4)")
    arguments = parser.parse_args()
    steps: list[StepClip] = []
    try:
        for file in arguments.file:
            sketch = parse_sketch(file.read_text(encoding="utf-8"), str(file))
            chosen = arguments.direction if arguments.direction in sketch.directions else sketch.directions[0]
            step = step_clip(sketch, chosen if sketch.travels else arguments.direction)
            steps.append(mirror_step(step) if arguments.mirrored else step)
    except (OSError, UnicodeDecodeError, SketchError) as error:
        print(error, file=sys.stderr)
        return 2
    (draw_step(steps[0], arguments.per_beat) if len(steps) == 1 else draw_sheet(steps)).save(arguments.picture)
    print(arguments.picture)
    return 0


def draw_step(step: StepClip, per_beat: int) -> Image.Image:
    """Strip of the whole step with `per_beat` figures a beat and the first figure of the next repetition."""
    clip = step.clip
    positions, rotations = forward_kinematics(clip.root_position, clip.rotation)
    samples_per_beat = step.samples_per_measure / step.beats_per_measure
    count = step.beats * per_beat + 1
    columns = min(count, 4 * per_beat + 1)
    rows = -(-count // columns)
    height = 2 * FIGURE + PLAN + 16
    image = Image.new("RGB", (columns * CELL, rows * height), (24, 24, 28))
    canvas = ImageDraw.Draw(image)
    last = round(step.first + step.beats * samples_per_beat)
    middle = float(0.5 * (clip.root_position[round(step.first), 2] + clip.root_position[last, 2]))
    for number in range(count):
        sample = round(step.first + number * samples_per_beat / per_beat)
        corner = number % columns * CELL, number // columns * height
        beat = number / per_beat
        canvas.text((corner[0] + 6, corner[1] + 2), f"{beat + 1:g}", fill=MIDDLE)
        _figure(canvas, corner, positions[sample] - (0.0, 0.0, middle), rotations[sample], clip.contact[sample])
    return image


SHEET_COLUMNS: Final = 4
SHEET_FIGURES: Final = 4
SHEET_SCALE: Final = 0.6


def draw_sheet(steps: Sequence[StepClip]) -> Image.Image:
    """Sheet of steps seen from the audience, each with its name and four figures, evenly spaced over its beats."""
    width, height = SHEET_FIGURES * CELL, 16 + FIGURE
    sheet = Image.new("RGB", (SHEET_COLUMNS * width, -(-len(steps) // SHEET_COLUMNS) * height), (24, 24, 28))
    for number, step in enumerate(steps):
        whole = draw_step(step, 1)
        left, top = number % SHEET_COLUMNS * width, number // SHEET_COLUMNS * height
        for figure in range(SHEET_FIGURES):
            row, column = divmod(round(figure * step.beats / SHEET_FIGURES), min(step.beats + 1, 5))
            x, y = column * CELL, row * (2 * FIGURE + PLAN + 16)
            sheet.paste(whole.crop((x, y + 16, x + CELL, y + 16 + FIGURE)), (left + figure * CELL, top + 16))
        ImageDraw.Draw(sheet).text((left + 6, top + 2), step.step, fill=MIDDLE, font_size=20)
    return sheet.resize((round(sheet.width * SHEET_SCALE), round(sheet.height * SHEET_SCALE)), Image.Resampling.LANCZOS)


def _figure(canvas: Canvas, corner: tuple[int, int], position: Float, rotation: Float, contact: Bool) -> None:
    middle = corner[0] + CELL / 2
    hips = position[0]
    floors = corner[1] + 16 + FIGURE - 14, corner[1] + 16 + 2 * FIGURE - 14
    for floor in floors:
        canvas.line((corner[0], floor, corner[0] + CELL, floor), fill=(70, 70, 76))

    def front(point: Float) -> tuple[float, float]:
        return middle + (point[0] - hips[0]) * PIXELS_PER_METRE, floors[0] - point[1] * PIXELS_PER_METRE

    def side(point: Float) -> tuple[float, float]:
        return middle - (point[2] - hips[2]) * PIXELS_PER_METRE, floors[1] - point[1] * PIXELS_PER_METRE

    plan = corner[1] + 16 + 2 * FIGURE + PLAN / 2

    def above(point: Float) -> tuple[float, float]:
        return middle + point[0] * PIXELS_PER_METRE * 0.6, plan + point[2] * PIXELS_PER_METRE * 0.6

    for view in (front, side):
        _body(canvas, view, position, rotation, contact)
    for index, name in enumerate(("left", "right")):
        heel, toe = _foot(position, rotation, name)[0], _foot(position, rotation, name)[2]
        colour = COLOURS[name] if contact[index] else (90, 90, 90)
        canvas.line((*above(heel), *above(toe)), fill=colour, width=4)
    x, y = above(hips)
    canvas.ellipse((x - 3, y - 3, x + 3, y + 3), outline=MIDDLE)


def _foot(position: Float, rotation: Float, name: str) -> list[Float]:
    """Heel, ball and tip of the toes on the sole."""
    ankle, toes = SKELETON.index(f"{name}Foot"), SKELETON.index(f"{name}Toes")
    heel = position[ankle] + _rotated(rotation[ankle], (0.0, -0.085, -0.05))
    ball = position[toes] + _rotated(rotation[toes], (0.0, -0.02, 0.0))
    return [heel, ball, position[toes] + _rotated(rotation[toes], (0.0, -0.02, 0.07))]


def _rotated(rotation: Float, vector: tuple[float, float, float]) -> Float:
    return quaternion.rotate(rotation, np.array(vector))


def _body(canvas: Canvas, view: View, position: Float, rotation: Float, contact: Bool) -> None:
    for joint, name in enumerate(SKELETON.names):
        parent = SKELETON.parents[joint]
        if parent < 0 or name.endswith("Toes"):
            continue
        colour = next((COLOURS[side] for side in COLOURS if name.startswith(side)), MIDDLE)
        canvas.line((*view(position[parent]), *view(position[joint])), fill=colour, width=4)
    for index, side in enumerate(("left", "right")):
        heel, ball, tip = (view(point) for point in _foot(position, rotation, side))
        canvas.line((*heel, *ball, *tip), fill=(90, 220, 110) if contact[index] else COLOURS[side], width=3)
        hand = SKELETON.index(f"{side}Hand")
        tip_of_hand = position[hand] + _rotated(rotation[hand], (0.16 if side == "left" else -0.16, 0.0, 0.0))
        canvas.line((*view(position[hand]), *view(tip_of_hand)), fill=COLOURS[side], width=3)
    head = SKELETON.index("head")
    middle = view(position[head] + _rotated(rotation[head], (0.0, 0.10, 0.02)))
    nose = view(position[head] + _rotated(rotation[head], (0.0, 0.09, 0.15)))
    radius = 0.105 * PIXELS_PER_METRE
    canvas.ellipse(
        (middle[0] - radius, middle[1] - radius * 1.15, middle[0] + radius, middle[1] + radius * 1.15), outline=MIDDLE
    )
    canvas.line((*middle, *nose), fill=MIDDLE, width=2)


if __name__ == "__main__":
    raise SystemExit(main())
