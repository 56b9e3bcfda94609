"""Rendering of a recorded journal to a film with its music."""

import contextlib
import math
from dataclasses import replace
from pathlib import Path

from rich.console import Console

from live.app.launch_options import LaunchOptions
from live.app.live_recording import film_sound, film_writer
from live.app.offline.film import make_renderer, make_sound_mixer, progress_bar
from live.base.errors import PersonError
from live.clock.ticks import TICK
from live.control.audio.music_file import Music, MusicFileError, read_music
from live.render.film.film_writer import FilmError
from live.render.film.streams import FilmSound
from live.show.journal.journal_reader import Journal
from live.show.journal.replay import Replayer, ReplayResult, ReplayStart
from live.show.loader import LoadedShow
from live.show.view.render_scene import draw_patch


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
) -> ReplayResult:
    """Render a journal from measure `first` to the end of `to` (from 1), comparing its hashes.

    The sound is the music file of the show, if there was one, with click and taps as in the patch. `alpha`: dancers
    without stage on a transparent background. A damaged line ends the film. Raise PersonError if rendering fails.
    """
    running = Replayer(start.show, journal.lines_with_damage(), tick=start.tick, to=to)
    running.advance_to(first)
    show, begin = running.show, running.tick * TICK
    if running.ended:
        raise PersonError(f"{journal.path}: it has no measure {first}; it ends in measure {show.span.number + 1}")
    music = _music(journal)
    heard = film_sound(music)
    mixed = make_sound_mixer(loaded, show, heard, begin=begin)
    frames = max(1, math.ceil((journal.last_tick * TICK - begin) * fps))
    with contextlib.ExitStack() as stack:
        target, renderer = make_renderer(
            stack, LaunchOptions(size=size, fps=fps), replace(loaded, patch=show.patch), fine, alpha=alpha
        )
        sound = mixed.film if mixed is not None else _music_from(music, begin)
        writer = stack.enter_context(film_writer(path, size=size, fps=fps, sound=sound, alpha=alpha))
        progress = stack.enter_context(progress_bar(Console(stderr=True)))
        task = progress.add_task("", total=frames if to is None else None)
        view, frame, patch = show.view(), 0, show.patch
        try:
            while not running.ended and running.damaged is None:
                time = begin + frame / fps
                running.advance(math.floor(time / TICK + 1e-9))
                if show.patch is not patch:
                    patch = show.patch
                    with contextlib.suppress(PersonError):  # as live: the last good pass stays
                        draw_patch(renderer, patch)
                show.fill(view, max(time, running.tick * TICK))
                if mixed is not None:
                    mixed.frame(view)
                renderer.draw(view, target.framebuffer)
                picture = target.push()
                if picture is not None:
                    writer.write(picture)
                progress.advance(task)
                frame += 1
            last = target.flush()
            if last is not None:
                writer.write(last)
            writer.close()
        except FilmError as error:
            raise PersonError(str(error)) from None
    return running.result


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
