"""Draw the pictures of the shows: `python tools/draw_pictures.py {shows|sheet|blind} ... [--before TREE]`.

`shows` draws docs/pictures/experiments and first-show.jpg, `sheet` docs/pictures/look/before-after.jpg, `blind`
docs/pictures/blind with its key. Before is what another checkout draws, as of `git worktree add TREE COMMIT`: each
tree draws with its own code, in a process of its own.

`python tools/draw_pictures.py look SHOW MEASURE ... [--out FOLDER]` draws what you want to look at.
"""

import argparse
import os
import random
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from PIL import Image, ImageDraw, ImageFont

ROOT: Final = Path(__file__).resolve().parents[1]
PICTURES: Final = ROOT / "docs" / "pictures"
SIZE: Final = (1280, 720)
"""In which a moment is drawn [pixels]; pages show it smaller, for smooth edges."""
LEAD_IN_S: Final = 1.2
"""So much is drawn before a moment: rings on water, trails and soft shadows have come by then."""
LEAD_IN_FPS: Final = 8
QUALITIES: Final = range(90, 30, -4)


@dataclass(frozen=True, slots=True)
class Moment:
    """A moment of a show."""

    show: str
    measure: float
    """From 1."""

    @property
    def file(self) -> str:
        """The name of its picture."""
        return f"{self.show}-{self.measure:g}.png"


EXPERIMENTS: Final = (
    Moment("samba", 13.5), Moment("tap", 24.6), Moment("contemporary", 8.4), Moment("ballet", 4.5),
)  # fmt: skip
FIRST_SHOW: Final = Moment("first_show", 22.5)
STAGED: Final = (*EXPERIMENTS, FIRST_SHOW)
"""The shows of the sheet before and after."""
RANKED: Final = (*STAGED, Moment("waltz", 8.4))
"""The shows of the blind order test."""
SEED: Final = 31
"""Of the order in the blind test."""
LARGEST: Final = {"experiments": 45_000, "first-show": 90_000, "sheet": 300_000, "blind": 60_000}
"""Largest files [bytes]."""


def draw_here(moments: list[Moment], folder: Path, tree: Path) -> None:
    """Draw moments with the code of a tree, in this process."""
    sys.path.insert(0, str(tree))
    import contextlib
    import math

    from bench._locomotion_run import engine_of
    from live.app.film.show_film import make_renderer
    from live.app.launch_options import LaunchOptions
    from live.show.loader import load_show
    from live.show.patch.patch_search_path import find_patch

    for moment in moments:
        loaded = load_show(find_patch(moment.show))
        beats = (moment.measure - 1.0) * loaded.patch.clock.beats_per_measure
        end = beats * 60.0 / loaded.patch.clock.bpm
        engine, clock, _ = engine_of(loaded.start(tempo=loaded.patch.clock.bpm))
        with contextlib.ExitStack() as stack:
            target, renderer = make_renderer(stack, LaunchOptions(size=SIZE), loaded, fine=True)
            frames = math.ceil(min(LEAD_IN_S, end) * LEAD_IN_FPS)
            for frame in range(-frames, 1):
                clock.set(end + frame / LEAD_IN_FPS)
                engine.frame(lambda _: None)
                renderer.draw(engine.view, target.framebuffer)
            Image.fromarray(target.read()).save(folder / moment.file)


def draw(moments: tuple[Moment, ...], tree: Path, folder: Path) -> list[Image.Image]:
    """Return the pictures that a tree draws of moments, (1280, 720) each; what the folder has is not drawn again."""
    folder.mkdir(parents=True, exist_ok=True)
    words = [f"{each.show}:{each.measure:g}" for each in moments if not (folder / each.file).exists()]
    command = [sys.executable, __file__, "here", *words, "--out", str(folder), "--tree", str(tree)]
    subprocess.run(command, cwd=tree, env=os.environ | {"PYTHONPATH": str(tree)}, check=True)
    return [Image.open(folder / each.file).convert("RGB") for each in moments]


def save(picture: Image.Image, path: Path, largest: int) -> None:
    """Save a picture in the best quality that fits; ValueError if none does."""
    path.parent.mkdir(parents=True, exist_ok=True)
    for quality in QUALITIES:
        picture.save(path, quality=quality, optimize=True, progressive=True)
        if path.stat().st_size <= largest:
            return
    raise ValueError(f"{path.name}: more than {largest} bytes even at the lowest quality")


def smaller(picture: Image.Image, width: int) -> Image.Image:
    """The picture with another width."""
    return picture.resize((width, round(width * picture.height / picture.width)), Image.Resampling.LANCZOS)


def draw_shows(scratch: Path) -> None:
    """Draw the pictures of the experiments and of the first show."""
    *four, first = draw(STAGED, ROOT, scratch / "now")
    for moment, picture in zip(EXPERIMENTS, four, strict=True):
        save(smaller(picture, 880), PICTURES / "experiments" / f"{moment.show}.jpg", LARGEST["experiments"])
    save(first, PICTURES / "first-show.jpg", LARGEST["first-show"])


def draw_sheet(scratch: Path, before: Path) -> None:
    """Draw one column for each show, before above after, with the same measures."""
    rows = [draw(STAGED, before, scratch / "before"), draw(STAGED, ROOT, scratch / "now")]
    width, gap, left, top = 420, 10, 84, 34
    height = width * SIZE[1] // SIZE[0]
    sheet = Image.new("RGB", (left + 5 * (width + gap), top + 2 * (height + gap)), (17, 18, 21))
    pen, font = ImageDraw.Draw(sheet), ImageFont.load_default(18)
    for row, (name, pictures) in enumerate(zip(("before", "after"), rows, strict=True)):
        y = top + row * (height + gap)
        pen.text((left - 12, y + height // 2), name, fill=(200, 200, 200), font=font, anchor="rm")
        for column, (moment, picture) in enumerate(zip(STAGED, pictures, strict=True)):
            x = left + column * (width + gap)
            title = f"{moment.show.replace('_', ' ')}, measure {int(moment.measure)}"
            pen.text((x, top - 10), title, fill=(200, 200, 200), font=font, anchor="ls")
            sheet.paste(picture.resize((width, height), Image.Resampling.LANCZOS), (x, y))
    save(sheet, PICTURES / "look" / "before-after.jpg", LARGEST["sheet"])


def draw_blind(scratch: Path, before: Path) -> None:
    """Draw the numbered pictures of the blind order test, and write its key."""
    drawn = [
        (moment, age, picture)
        for age, tree in (("before", before), ("now", ROOT))
        for moment, picture in zip(RANKED, draw(RANKED, tree, scratch / age), strict=True)
    ]
    random.Random(SEED).shuffle(drawn)  # the key is no secret: nothing is protected by this order
    rows = []
    for number, (moment, age, picture) in enumerate(drawn, 1):
        save(smaller(picture, 800), PICTURES / "blind" / f"{number:02d}.jpg", LARGEST["blind"])
        rows.append(f"| {number:02d} | {moment.show} | {moment.measure:g} | {age} |")
    key = ROOT / "docs" / "explanation" / "blind-test-key.md"
    head = key.read_text(encoding="utf-8").split("| picture |")[0]
    table = ["| picture | show | measure | drawn |", "|-|-|-|-|", *rows]
    key.write_text(head + "\n".join(table) + "\n", encoding="utf-8")


def main() -> None:
    """Draw what the command line says."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", nargs="+", help="shows, sheet, blind; or look SHOW MEASURE ...")
    parser.add_argument("--before", type=Path, help="a checkout of the commit that draws what was before")
    parser.add_argument("--out", type=Path, default=Path("."), help="the folder for look")
    parser.add_argument("--tree", type=Path, default=ROOT, help=argparse.SUPPRESS)
    said = parser.parse_args()
    if said.what[0] == "here":
        moments = [word.rsplit(":", 1) for word in said.what[1:]]
        draw_here([Moment(show, float(measure)) for show, measure in moments], said.out, said.tree)
        return
    if said.what[0] == "look":
        draw(tuple(Moment(said.what[1], float(each)) for each in said.what[2:]), ROOT, said.out.resolve())
        return
    if said.before is None and {"sheet", "blind"} & set(said.what):
        parser.error("sheet and blind need --before")
    with tempfile.TemporaryDirectory() as folder:
        for what in said.what:
            if what == "shows":
                draw_shows(Path(folder))
            else:
                {"sheet": draw_sheet, "blind": draw_blind}[what](Path(folder), said.before.resolve())


if __name__ == "__main__":
    main()
