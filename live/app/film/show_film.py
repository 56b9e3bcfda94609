"""Offline rendering of a show to a film, or to a file of its motion: an engine whose clock is set frame by frame."""

import contextlib
import json
import math
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from live.app.film.film_output import FilmOutput, MotionOutput, PictureOutput
from live.app.film.live_recording import film_sound, film_writer
from live.app.launch_options import LaunchOptions
from live.app.services.midi_service import attach_midi_file
from live.app.session_audio import AudioChoice, make_map_clock, make_show_analysis, start_tempo
from live.app.session_records import resident_megabytes
from live.base.errors import PersonError
from live.base.event_queue import EventQueue
from live.clock.ticks import FrameGrid
from live.clock.time_source import ManualClock
from live.control.audio.music_file import OfflineMusic
from live.control.events.events import ControlEvent
from live.library.motion_formats import stage_format
from live.render.adaptive_quality import film_quality
from live.render.film.streams import FilmSound
from live.render.headless import NoOpenGL, OffscreenTarget, create_headless_context, release_headless_context
from live.render.renderer import Renderer
from live.show.engine import Engine
from live.show.journal.journal import JournalError, JournalWriter
from live.show.journal.motion_report import MotionReport
from live.show.loader import LoadedShow
from live.show.show import Show
from live.show.sound.soundtrack import Soundtrack
from live.show.stages.row_threads import row_threads
from live.show.view.status import Status, StatusFile


def film_show(
    options: LaunchOptions,
    loaded: LoadedShow,
    sound: AudioChoice,
    *,
    path: Path,
    seconds: float,
    console: Console,
    report: Path | None = None,
    fine: bool = False,
    guides: bool = False,
    click: bool | None = None,
    taps: bool | None = None,
    alpha: bool = False,
) -> str:
    """Render `seconds` of the show to `path`: a film, or by its suffix the dancers' motion; with `report`, write motion
    figures as JSON. Return where it is.

    `click`, `taps`: add a click track and the taps of the dancers' feet; None: as in the patch.
    `alpha`: dancers without stage on a transparent background; drawn as with `fine`.
    `fine`: draw as on a graphics card even without one, which takes about five times as long per picture.
    `guides`: draw the operator's guides. An interrupted film is closed properly and plays up to there.
    """
    tempo = start_tempo(options, loaded, sound)
    show = loaded.start(seed=options.seed, tempo=tempo)
    clock = ManualClock()
    inbox: EventQueue[ControlEvent] = EventQueue()
    status = Status(show, rejected=Counter, memory=resident_megabytes())
    engine = Engine(show, clock=clock, inbox=inbox, status=status, lead=0.0, stall=math.inf)
    one_at = loaded.patch.music.first_downbeat if sound.from_patch else None
    music = None
    if sound.music is not None:
        music = OfflineMusic(
            sound.music,
            one_at=one_at,
            analysis=make_show_analysis(sound, loaded, show, make_map_clock(sound, loaded.patch)),
        )
    engine.guides = guides
    attach_midi_file(options.midi_file, show, engine)
    grid = FrameGrid(options.film_fps)
    frames = grid.count(seconds)
    figures = MotionReport(show) if report is not None else None
    heard = film_sound(sound.music)
    as_motion = stage_format(path.suffix) is not None
    mixed = None if as_motion else make_sound_mixer(loaded, show, heard, click, taps)
    with contextlib.ExitStack() as stack:
        stack.enter_context(row_threads())
        output: FilmOutput
        if as_motion:
            output = MotionOutput(loaded, show, path, frames=frames, fps=options.film_fps, begin=0.0)
            engine.view.detailed = True  # no camera spares them
        else:
            film = heard if mixed is None else mixed.film
            output = picture_output(stack, options, loaded, path, film, fine=fine, alpha=alpha)
        engine.journal = _journal(stack, options, loaded, show, tempo, engine, sound.path, seconds)
        lines = _status_file(stack, options, status, clock)
        progress = stack.enter_context(progress_bar(console))
        task = progress.add_task("", total=frames)
        for frame in range(frames):
            now = grid.time(frame)
            clock.set(now)
            # what acts after the last tick is seen after the next one, as in a replay
            for event in music.events_until(now) if music is not None and engine.ticks.is_due(now) else ():
                inbox.put(event)
            engine.frame(output.draw)
            if figures is not None:
                figures.frame(engine.view)
            if mixed is not None:
                mixed.frame(engine.view)
            if lines is not None:
                lines.frame(now)
            output.advance()
            progress.advance(task)
        made = output.close()
    if report is not None and figures is not None:
        _write_report(report, figures.result() | {"status": status.snapshot(frames / options.film_fps)})
    return made


def picture_output(
    stack: contextlib.ExitStack,
    options: LaunchOptions,
    loaded: LoadedShow,
    path: Path,
    sound: FilmSound | None,
    *,
    fine: bool,
    alpha: bool,
    first: int = 0,
) -> PictureOutput:
    """Return the output to a film with `sound`, closed with the stack; PersonError if it cannot be drawn or written.

    `first`: number of its first frame in the whole show.
    """
    target, renderer = make_renderer(stack, options, loaded, fine, alpha=alpha)
    writer = stack.enter_context(
        film_writer(path, size=options.size, fps=options.film_fps, sound=sound, alpha=alpha, first=first)
    )
    return PictureOutput(renderer, target, writer, path)


def make_sound_mixer(
    loaded: LoadedShow,
    show: Show,
    music: FilmSound | None,
    click: bool | None = None,
    taps: bool | None = None,
    *,
    begin: float = 0.0,
) -> Soundtrack | None:
    """Return a film's sound mixer from `begin` [s] of the show; None if there is nothing to add to the music."""
    own = loaded.patch.sound
    click, taps = own.click if click is None else click, own.taps if taps is None else taps
    return Soundtrack(show, music, click=click, taps=taps, begin=begin) if click or taps else None


def make_renderer(
    stack: contextlib.ExitStack, options: LaunchOptions, loaded: LoadedShow, fine: bool, *, alpha: bool = False
) -> tuple[OffscreenTarget, Renderer]:
    """Return render target and renderer, released with the stack; raise PersonError if the driver cannot draw this."""
    try:
        ctx = create_headless_context()
    except NoOpenGL as error:
        raise PersonError(str(error)) from None
    stack.callback(release_headless_context, ctx)
    try:
        target = OffscreenTarget(ctx, options.size, alpha=alpha)
        stack.callback(target.release)
        quality = film_quality(ctx, options.size[1]) if fine and not alpha else None
        renderer = Renderer(
            ctx, loaded.scene(), size=options.size, quality=quality, blocking_video=True, transparent=alpha,
            warm_up=False,
        )  # fmt: skip
    except ValueError as error:
        raise PersonError(f"{error}") from None
    stack.callback(renderer.release)
    return target, renderer


def _journal(
    stack: contextlib.ExitStack,
    options: LaunchOptions,
    loaded: LoadedShow,
    show: Show,
    tempo: float | None,
    engine: Engine,
    music: Path | None,
    seconds: float,
) -> JournalWriter | None:
    if options.journal is None:
        return None
    try:
        journal = JournalWriter(options.journal, loaded.header(show, tempo=tempo, music=music))
    except JournalError as error:
        raise PersonError(str(error)) from None
    stack.push(lambda kind, *_: journal.close(engine.ticks.index, seconds=None if kind else seconds))
    return journal


def _status_file(
    stack: contextlib.ExitStack, options: LaunchOptions, status: Status, clock: ManualClock
) -> StatusFile | None:
    if options.status_json is None:
        return None
    try:
        lines = StatusFile(options.status_json, status)
    except OSError as error:
        raise PersonError(f"cannot write --status-json {options.status_json}: {error.strerror}") from None
    stack.callback(lambda: lines.close(clock.now()))
    return lines


def progress_bar(console: Console) -> Progress:
    """Return a progress bar for the frames of a film."""
    return Progress(
        TextColumn("rendering"), BarColumn(), MofNCompleteColumn(), TextColumn("frames"), TimeRemainingColumn(),
        console=console,
    )  # fmt: skip


def _write_report(path: Path, figures: dict[str, Any]) -> None:
    try:
        path.write_text(json.dumps(figures, indent=1, default=_json_default) + "\n", encoding="utf-8")
    except OSError as error:
        raise PersonError(f"cannot write the report {path}: {error.strerror}") from None


def _json_default(value: Any) -> Any:
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"{type(value).__name__} in a report")
