"""Rendering of a recorded journal to a film with its music, whole or a part of it."""

import contextlib
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from rich.console import Console

from live.app.film.film_output import FilmOutput, MotionOutput
from live.app.film.film_plan import FilmPart, FilmPlan, whole_show
from live.app.film.live_recording import film_sound
from live.app.film.show_film import make_sound_mixer, picture_output, progress_bar
from live.app.launch_options import LaunchOptions
from live.base.errors import PersonError
from live.clock.ticks import TICK, FrameGrid
from live.control.audio.music_file import Music, MusicFileError, read_music
from live.library.motion_formats import stage_format
from live.render.film.streams import FilmSound
from live.show.journal.journal_reader import Journal
from live.show.journal.replay import Replayer, ReplayResult
from live.show.loader import LoadedShow
from live.show.patch.patch import Patch
from live.show.sound.soundtrack import Soundtrack
from live.show.stages.row_threads import row_threads


@dataclass(frozen=True, slots=True)
class FilmLook:
    """How the pictures of a film are drawn."""

    size: tuple[int, int]
    """Width and height [pixels]."""
    grid: FrameGrid
    fine: bool = False
    """As on a graphics card, even without one."""
    alpha: bool = False
    """Dancers without stage on a transparent background."""


def film_replay(
    journal: Journal,
    loaded: LoadedShow,
    path: Path,
    look: FilmLook,
    frames: tuple[int, int],
    *,
    to_end: bool,
    problems: list[str],
    console: Console,
    on_drawn: Callable[[int], None],
) -> tuple[ReplayResult, str]:
    """Render the `frames` of a journal (half-open, of the whole show); return how its hashes compare, and where the
    file is. `to_end`: with them the show ends. `on_drawn` is told how many more frames are drawn.

    By its suffix the path is a film or the dancers' motion. The sound is the music file of the show, if there was one,
    with click and taps as in the patch. Raise PersonError if rendering fails.
    """
    part = whole_show(frames[1])
    if frames[0]:
        plan = FilmPlan(journal, loaded, look.grid, frames, problems=problems, to_end=to_end)
        part = next(found for found in plan.parts(whole=False) if found is not None)
    start = part.start(journal, loaded)
    running = Replayer(start.show, journal.lines_with_damage(), tick=start.tick)
    begin = look.grid.time(part.first)
    as_motion = stage_format(path.suffix) is not None
    music = None if as_motion else journal_music(journal)
    mixed = None if as_motion else make_sound_mixer(loaded, start.show, film_sound(music), begin=begin)
    with contextlib.ExitStack() as stack:
        stack.enter_context(row_threads())
        output: FilmOutput
        if as_motion:
            current = replace(loaded, patch=start.show.patch)
            output = MotionOutput(
                current, start.show, path, frames=part.count, fps=look.grid.fps, begin=begin
            )  # fmt: skip
        else:
            sound = mixed.film if mixed is not None else music_from(music, begin)
            options = LaunchOptions(size=look.size, fps=look.grid.fps)
            picture = picture_output(
                stack, options, loaded, path, sound, fine=look.fine, alpha=look.alpha, first=part.first
            )
            picture.begin_anew(part.titles)
            output = picture
        progress = stack.enter_context(progress_bar(console))
        task = progress.add_task("", total=part.count)
        for _ in draw_part(part, running, output, look.grid, loaded.patch, mixed, detailed=as_motion):
            progress.advance(task)
            on_drawn(1)
        if to_end:
            running.advance(math.inf)
        made = output.close()
    return running.result, made


def draw_part(
    part: FilmPart,
    running: Replayer,
    output: FilmOutput,
    grid: FrameGrid,
    patch: Patch,
    mixed: Soundtrack | None = None,
    *,
    detailed: bool = False,
) -> Iterator[int]:
    """Draw a part, after what its pictures remember of the frames before; yield each of its frames that is done.

    `running`: at the part's start. `patch`: the one that `output` draws. `detailed`: no camera spares the dancers.
    """
    show = running.show
    view = show.view()
    view.detailed = detailed
    for frame in range(part.reach.follow, part.end):
        running.advance(grid.tick(frame))
        if show.patch is not patch:
            patch = show.patch
            output.change_patch(patch)
        show.fill(view, max(grid.time(frame), running.tick * TICK))
        if frame < part.reach.draw:
            output.follow(view)
        elif frame < part.first:
            output.warm_up(view)
        else:
            if mixed is not None:
                mixed.frame(view)
            output.draw(view)
            output.advance()
            yield frame


def journal_music(journal: Journal) -> Music | None:
    """Read the journal's music file; None if there was none. Raise PersonError if the file is missing."""
    name = journal.header.get("music")
    if name is None:
        return None
    try:
        return read_music(Path(name))
    except MusicFileError as error:
        raise PersonError(str(error)) from None


def music_from(music: Music | None, begin: float) -> FilmSound | None:
    """Return the music alone, from `begin` [s] of the show."""
    if music is None:
        return None
    return FilmSound.from_samples(music.samples, music.sample_rate, start=begin, loop=True)
