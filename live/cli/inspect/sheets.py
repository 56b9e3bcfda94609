"""Command `live sheets`: storyboard, a sheet for each dancer, and marks for the musician, to print."""

from pathlib import Path
from typing import Annotated

import typer


def sheets(
    show: Annotated[str | None, typer.Argument(help="A patch. Default: the first show.", metavar="SHOW")] = None,
    out: Annotated[
        Path | None, typer.Option(help="The folder to write. Default: one of the show's name, here.", metavar="DIR")
    ] = None,
    paper: Annotated[str, typer.Option(help="a4 or letter.")] = "a4",
    measures: Annotated[
        int | None, typer.Option(min=1, max=400, help="Measures of the show. Default: to the end of its score.")
    ] = None,
    pictures: Annotated[bool, typer.Option(help="Write each page as a PNG, too.")] = True,
    steps: Annotated[Path | None, typer.Option(help="Use the recordings of this folder.", file_okay=False)] = None,
    seed: Annotated[
        int | None, typer.Option(min=0, max=2**31 - 1, help="Random seed of the show. Default: the patch's.")
    ] = None,
) -> None:
    """Write a show on paper for real dancers: storyboard.pdf, a page or more for each dancer, markers.mid and
    markers.txt for the musician, and all pages as pictures.

    The show is simulated as it is danced live, without input; where its score waits, the sheets go on at once.
    """
    import time

    from rich.console import Console

    from live.app.machine.kernel_warmup import warm_kernels
    from live.base.errors import PersonError
    from live.document.sheets.sheet_files import SheetFolder, sheet_names, write_sheets
    from live.show.patch.patch_search_path import find_patch, show_stem

    paper = paper.casefold()
    if paper not in ("a4", "letter"):
        raise PersonError(f"--paper {paper!r}: a4 or letter expected", "--paper a4")
    find_patch(show)  # reports an unknown name before seconds of loading
    console = Console(stderr=True, highlight=False)
    warm_kernels(console)  # before modules with kernels are imported
    from live.app.launch_options import LaunchOptions
    from live.document.sheets.score_course import course_of
    from live.document.sheets.sheet_book import book_of
    from live.document.sheets.show_record import record_show
    from live.show.loader import make_scene

    loaded = LaunchOptions(patch=show, steps=steps).load()
    patch = loaded.patch
    out = out or Path(f"{Path(show_stem(show or 'first_show')).stem}-sheets")
    folder = SheetFolder(out)
    folder.check(sheet_names(patch))
    course = course_of(patch, measures)
    began = time.monotonic()

    def report(words: str) -> None:
        if console.is_terminal:
            console.print(f"{words:<60}", end="\r", markup=False)

    total = len(course.measures)
    record = record_show(loaded.start(seed=seed), course, lambda measure: report(f"measure {measure + 1} of {total}"))
    book = book_of(patch, record, make_scene(patch).group_colours)
    done = write_sheets(folder, patch, book, paper, pictures=pictures, progress=report)
    people = len(book.dancers)
    console.print(
        f"{out.resolve()}: storyboard and sheets of {people} dancer{'s' if people != 1 else ''}, {done.pages} pages "
        f"in {done.pdfs} PDFs, {done.pictures} pictures, markers; {time.monotonic() - began:.0f} s",
        soft_wrap=True, markup=False,
    )  # fmt: skip
    if done.left:
        words = f"{len(done.left)} files of an earlier run are left there, such as {done.left[0]}"
        console.print(words, soft_wrap=True, markup=False)
