"""Rendering of a recorded journal to a film with its music."""

import contextlib
import math
from dataclasses import replace
from pathlib import Path

from rich.console import Console

from live.app.film.film_output import FilmOutput, MotionOutput
from live.app.film.live_recording import film_sound
from live.app.film.show_film import make_sound_mixer, picture_output, progress_bar
from live.app.launch_options import LaunchOptions
from live.base.errors import PersonError
from live.clock.ticks import TICK
from live.control.audio.music_file import Music, MusicFileError, read_music
from live.library.motion_formats import stage_format
from live.render.film.streams import FilmSound
from live.show.journal.journal_reader import Journal
from live.show.journal.replay import Replayer, ReplayResult, ReplayStart
from live.show.loader import LoadedShow


def film_replay(
    start: ReplayStart,
    journal: Journal,
    loaded: LoadedShow,
    path: Path,
    size: tuple[int, int],
    fps: float,
    *,
    first: int = 1,
    to: int | None = None,
    fine: bool = False,
    alpha: bool = False,
) -> tuple[ReplayResult, str]:
    """Render a journal from measure `first` to the end of `to` (from 1); return how its hashes compare, and where the
    file is.

    By its suffix the path is a film or the dancers' motion.

    The sound is the music file of the show, if there was one, with click and taps as in the patch. `alpha`: dancers
    without stage on a transparent background. A damaged line ends the film. Raise PersonError if rendering fails.
    """
    running = Replayer(start.show, journal.lines_with_damage(), tick=start.tick, to=to)
    running.advance_to(first)
    show, begin = running.show, running.tick * TICK
    if running.ended:
        raise PersonError(f"{journal.path}: it has no measure {first}; it ends in measure {show.span.number + 1}")
    as_motion = stage_format(path.suffix) is not None
    music = None if as_motion else _music(journal)
    mixed = None if as_motion else make_sound_mixer(loaded, show, film_sound(music), begin=begin)
    frames = max(1, math.ceil((journal.last_tick * TICK - begin) * fps))
    with contextlib.ExitStack() as stack:
        current = replace(loaded, patch=show.patch)
        output: FilmOutput
        if as_motion:
            output = MotionOutput(current, show, path, frames=frames if to is None else 0, fps=fps, begin=begin)
        else:
            sound = mixed.film if mixed is not None else _music_from(music, begin)
            options = LaunchOptions(size=size, fps=fps)
            output = picture_output(stack, options, current, path, sound, fine=fine, alpha=alpha)
        progress = stack.enter_context(progress_bar(Console(stderr=True)))
        task = progress.add_task("", total=frames if to is None else None)
        view, frame, patch = show.view(), 0, show.patch
        view.detailed = as_motion  # no camera spares them
        while not running.ended and running.damaged is None:
            time = begin + frame / fps
            running.advance(math.floor(time / TICK + 1e-9))
            if show.patch is not patch:
                patch = show.patch
                output.change_patch(patch)
            show.fill(view, max(time, running.tick * TICK))
            if mixed is not None:
                mixed.frame(view)
            output.draw(view)
            output.advance()
            progress.advance(task)
            frame += 1
        made = output.close()
    return running.result, made


def _music(journal: Journal) -> Music | None:
    """Read the journal's music file; None if there was none. Raise PersonError if the file is missing."""
    name = journal.header.get("music")
    if name is None:
        return None
    try:
        return read_music(Path(name))
    except MusicFileError as error:
        raise PersonError(str(error)) from None


def _music_from(music: Music | None, begin: float) -> FilmSound | None:
    """Return the music alone, from `begin` [s] of the show."""
    if music is None:
        return None
    return FilmSound.from_samples(music.samples, music.sample_rate, start=begin, loop=True)
