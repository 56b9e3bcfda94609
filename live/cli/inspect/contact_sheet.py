"""Command `live contact-sheet`: draws pictures of a whole show on one sheet."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from collections.abc import Iterator

    from live.app.offline.sheet_moments import SheetMoment
    from live.base.stage_snapshot import StageView
    from live.show.loader import LoadedShow
    from live.show.show import Show

DEFAULT_PICTURES = 24
"""Approximate number of pictures of a sheet without --every."""


def contact_sheet(
    show: Annotated[str, typer.Argument(help="A journal, or a patch.", metavar="JOURNAL|PATCH")],
    out: Annotated[
        Path | None,
        typer.Option(help="The picture to write. Default: one of the show's name, here.", metavar="FILE.png"),
    ] = None,
    every: Annotated[
        int | None, typer.Option(min=1, help="Measures between pictures. Default: about 24 pictures in all.")
    ] = None,
    columns: Annotated[int, typer.Option(min=1, max=24, help="Pictures per row.")] = 4,
    width: Annotated[int, typer.Option(min=160, max=1920, help="Width of each picture in pixels.")] = 480,
    seconds: Annotated[
        float | None, typer.Option(help="Length of a patch's show. Default: the music's, the score's, or 60 s.")
    ] = None,
    seed: Annotated[int | None, typer.Option(min=0, max=2**31 - 1, help="Random seed of a patch's show.")] = None,
    light: Annotated[bool, typer.Option("--light", help="Dark on light, for paper.")] = False,
    fine: Annotated[bool, typer.Option("--fine", help="Draw at GPU quality even without a GPU.")] = False,
) -> None:
    """Draw a contact sheet: pictures of a show with measure, section, cue, and each group's step."""
    import contextlib
    from dataclasses import replace

    from rich.console import Console

    from live.app.machine.kernel_warmup import warm_kernels
    from live.app.option_values import check_range, check_writable
    from live.base.errors import PersonError
    from live.show.patch.patch_search_path import show_stem

    check_range(seconds, "--seconds", 1.0, 86400)
    out = out or Path(f"{Path(show_stem(show)).stem}.png")
    check_writable(out, "--out")
    if out.suffix.lower() not in (".png", ".jpg"):
        raise PersonError(f"--out {out}: a picture's name ends in .png or .jpg", f"--out {out.with_suffix('.png')}")
    console = Console(stderr=True, highlight=False)
    warm_kernels(console)  # before modules with kernels are imported
    from live.app.film.show_film import make_renderer
    from live.app.launch_options import LaunchOptions
    from live.app.pictures.sheet_picture import DARK, LIGHT, MAX_HEIGHT, Sheet

    size = (width, round(width * 9 / 16))
    options = LaunchOptions(patch=show, seed=seed, size=size)
    journal = Path(show).is_file() and Path(show).suffix.lower() != ".toml"
    loaded, moments = _journal_moments(Path(show), every) if journal else _patch_moments(options, seconds, every)
    sheet = Sheet(size, columns, LIGHT if light else DARK)
    pictures = []
    with contextlib.ExitStack() as stack:
        target, renderer = make_renderer(stack, replace(options, size=size), loaded, fine)
        for view, taken in moments:
            renderer.draw(view, target.framebuffer)
            if taken is not None:
                pictures.append((target.read().copy(), taken))
                if console.is_terminal:
                    console.print(f"measure {taken.measure}", end="\r")
                if sheet.size_for(len(pictures))[1] > MAX_HEIGHT:
                    raise PersonError(
                        f"{len(pictures)} pictures are too many for a sheet", "give a larger --every, or more --columns"
                    )
    if not pictures:
        raise PersonError(f"{show}: no measure in it is long enough for a picture", "give more --seconds")
    last = pictures[-1][1]
    told = f"to measure {last.measure}   {int(last.seconds) // 60}:{int(last.seconds) % 60:02d}"
    drawn = sheet.draw(pictures, loaded.patch.name, told)
    try:
        drawn.save(out)
    except OSError as error:
        raise PersonError(f"--out {out}: cannot be written: {error.strerror or error}") from None
    console.print(f"{len(pictures)} pictures: {out.resolve()}", soft_wrap=True, markup=False)


def _journal_moments(
    path: Path, every: int | None
) -> "tuple[LoadedShow, Iterator[tuple[StageView, SheetMoment | None]]]":
    from dataclasses import replace

    from live.app.offline.sheet_moments import measure_count, moments_of_journal
    from live.base.errors import PersonError
    from live.show.journal.journal_reader import JournalError, read_journal
    from live.show.journal.replay import Replayer, ReplayError, load_journal, start_before

    try:
        journal = read_journal(path)
        loaded = load_journal(journal)
        start = start_before(journal, loaded, 1, [])
    except (JournalError, ReplayError) as error:
        raise PersonError(str(error)) from None
    running = Replayer(start.show, journal.lines_with_damage(), tick=start.tick, compare=False)
    moments = moments_of_journal(running, every or _measures_between(measure_count(journal)))
    return replace(loaded, patch=start.show.patch), moments


def _patch_moments(
    options: Any, seconds: float | None, every: int | None
) -> "tuple[LoadedShow, Iterator[tuple[StageView, SheetMoment | None]]]":
    from live.app.offline.sheet_moments import moments_of_patch
    from live.app.session_audio import choose_audio, start_tempo
    from live.base.errors import PersonError

    loaded = options.load()
    sound = choose_audio(options, loaded)
    if sound.device is not None:
        raise PersonError(f"{options.patch}: its sound comes from a device; record a journal and draw that")
    show = loaded.start(seed=options.seed, tempo=start_tempo(options, loaded, sound))
    measure = show.timeline.beats_per_measure * 60.0 / show.timeline.tempo
    length = seconds or (sound.music.duration if sound.music is not None else _score_duration(show, measure))
    every = every or _measures_between(round(length / measure))
    return loaded, moments_of_patch(loaded, show, sound, length, every)


def _score_duration(show: "Show", measure: float) -> float:
    """Return the length of the score [s] for measures of `measure` [s]; a minute if it has no end."""
    length = show.playhead.length
    return 60.0 if length is None else length * measure


def _measures_between(measures: int) -> int:
    """Return the number of measures between pictures: the power of two that gives about two dozen."""
    every = 1
    while measures / every > DEFAULT_PICTURES:
        every *= 2
    return every
