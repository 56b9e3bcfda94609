"""Command `live score`: prints or draws a show's score by measures: sections, signals, steps, motion, calls."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from live.show.score.score_sheet import Sheet


def score(
    patch: Annotated[str | None, typer.Argument(help="A patch. Default: the first show.")] = None,
    svg: Annotated[Path | None, typer.Option(help="Draw it with a box for each measure.", metavar="OUT.svg")] = None,
    steps: Annotated[Path | None, typer.Option(help="Use the recordings of this folder.", file_okay=False)] = None,
    seed: Annotated[int | None, typer.Option(help="Random seed of improvised steps. Default: the patch's.")] = None,
    per_row: Annotated[int, typer.Option("--per-row", help="Measures per row of the picture.")] = 16,
    as_json: Annotated[bool, typer.Option("--json", help="Print it as JSON.")] = False,
) -> None:
    """Print or draw the score of a patch as written, every section once.

    Steps with ~ are chosen at random, in a show also by the dancers' positions. Steps in brackets are the group's own.
    """
    from rich.console import Console

    from live.app.machine.kernel_warmup import warm_kernels
    from live.app.option_values import check_range
    from live.show.patch.patch_search_path import find_patch

    find_patch(patch)  # reports an unknown name before seconds of loading
    warm_kernels(Console(stderr=True))  # before modules with kernels are imported
    from live.app.launch_options import LaunchOptions
    from live.show.score.score_sheet import build_sheet

    check_range(seed, "--seed", 0, 2**31 - 1)
    check_range(per_row, "--per-row", 1, 256)
    loaded = LaunchOptions(patch=patch, steps=steps).load()
    sheet = build_sheet(loaded.start(seed=seed))
    if svg is not None:
        _draw(sheet, svg, per_row, loaded.patch)
    if as_json:
        print(json.dumps(sheet.as_json()))
        return
    console = Console(highlight=False)
    for line in describe_sheet(sheet):
        console.print(line, soft_wrap=True, markup=False)
    if svg is not None:
        console.print(f"{svg}: drawn", soft_wrap=True, markup=False)


def describe_sheet(sheet: "Sheet") -> list[str]:
    """Return the sheet as text lines: under each section, the boxes of each track with their measures."""
    lines = []
    sections = next(track for track in sheet.tracks if track.name == "section")
    for section in sections.boxes:
        lines.append(f"{section.label}: measures {section.first + 1} to {section.last + 1}")
        for track in sheet.tracks:
            if track is sections:
                continue
            words = [
                f"{box.first + 1}{'' if box.first == box.last else f'-{box.last + 1}'} {_mark(box.label, box.kind)}"
                for box in track.boxes
                if section.first <= box.first <= section.last
            ]
            if words:
                lines.append(f"  {track.name:>10}: {', '.join(words)}")
    return lines


def _mark(words: str, kind: str) -> str:
    return f"~{words}" if kind == "improvised" else f"({words})" if kind == "own" else words


def _draw(sheet: "Sheet", to: Path, per_row: int, patch: object) -> None:
    from live.app.option_values import check_writable
    from live.app.pictures.score_picture import score_picture
    from live.base.errors import PersonError
    from live.library.whole_file import write_atomically
    from live.show.loader import make_scene
    from live.show.patch.patch import Patch

    assert isinstance(patch, Patch)
    if to.suffix.lower() != ".svg":
        raise PersonError(f"--svg {to}: a name that ends in .svg expected", f"--svg {to.stem or 'score'}.svg")
    check_writable(to, "--svg")
    colours = ["#" + "".join(f"{round(255 * part):02x}" for part in each) for each in make_scene(patch).group_colours]
    write_atomically(score_picture(sheet, colours, per_row=per_row).encode(), to, "--svg")
