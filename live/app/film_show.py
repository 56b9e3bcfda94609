"""A show as a film, offline: the same engine on a clock that is set frame by frame, faster or slower than life."""

import contextlib
import json
import math
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from live.app.memory import resident_megabytes
from live.app.recording import film_sound, film_writer
from live.app.services.midi_file_part import play_file
from live.app.session_sound import Sound, analysis_for
from live.app.starting_tempo import start_tempo
from live.app.wish import Wish
from live.base.errors import PersonError
from live.base.inbox import Inbox
from live.base.stage_snapshot import StageView
from live.clock.time_source import ManualClock
from live.control.audio.music_file import OfflineMusic
from live.control.events.events import ControlEvent
from live.render.film.film_sound import FilmSound
from live.render.film.film_writer import FilmError
from live.render.headless import NoOpenGL, OffscreenTarget, create_headless_context, release_headless_context
from live.render.quality import CARD
from live.render.renderer import Renderer
from live.show.core import Show
from live.show.engine import Engine
from live.show.journal.journal import JournalError, JournalWriter
from live.show.journal.motion_report import FrameReport
from live.show.load import LoadedShow
from live.show.sound.show_sound import ShowSound
from live.show.status import Status, StatusFile


def film_show(
    wish: Wish,
    loaded: LoadedShow,
    sound: Sound,
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
) -> None:
    """Render `seconds` of the show to `path`; with `report`, the figures of what was danced as JSON.

    `click`, `taps`: whether a click track and the taps of the dancers' feet are heard; None: as the patch says.

    `alpha`: the dancers without their stage, on nothing; drawn as with `fine`.
    `fine`: draw as on a graphics card even without one; a picture then takes some five times as long.
    `guides`: with the operator's guides in it. A film that is broken off is closed properly and plays to there.
    """
    tempo = start_tempo(wish, loaded, sound)
    show = loaded.start(seed=wish.seed, tempo=tempo)
    clock = ManualClock()
    inbox: Inbox[ControlEvent] = Inbox()
    status = Status(show, rejected=Counter, memory=resident_megabytes())
    engine = Engine(show, clock=clock, inbox=inbox, status=status, stall=math.inf)
    one_at = loaded.patch.music.one_at_s if sound.known else None
    music = None
    if sound.music is not None:
        music = OfflineMusic(sound.music, loop=True, one_at=one_at, analysis=analysis_for(loaded, show))
    engine.guides = guides
    play_file(wish.midi_file, show, engine)
    frames = max(1, math.ceil(seconds * wish.film_fps))
    figures = FrameReport(show) if report is not None else None
    heard = film_sound(sound.music)
    mixed = mixed_sound(loaded, show, heard, click, taps)
    with contextlib.ExitStack() as stack:
        target, renderer = canvas(stack, wish, loaded, fine, alpha=alpha)
        writer = stack.enter_context(
            film_writer(
                path, size=wish.size, fps=wish.film_fps, sound=heard if mixed is None else mixed.film, alpha=alpha
            )
        )
        engine.journal = _journal(stack, wish, loaded, show, tempo, engine, sound.path)
        lines = _status_file(stack, wish, status, clock)

        def draw(view: StageView) -> None:
            renderer.draw(view, target.framebuffer)

        progress = stack.enter_context(progress_bar(console))
        task = progress.add_task("", total=frames)
        try:
            for frame in range(frames):
                now = frame / wish.film_fps
                clock.set(now)
                for event in [] if music is None else music.events_until(now):
                    inbox.put(event)
                engine.frame(draw)
                if figures is not None:
                    figures.frame(engine.view)
                if mixed is not None:
                    mixed.frame(engine.view)
                if lines is not None:
                    lines.frame(now)
                picture = target.push()
                if picture is not None:
                    writer.write(picture)
                progress.advance(task)
            last = target.flush()
            if last is not None:
                writer.write(last)
            writer.close()
        except FilmError as error:
            raise PersonError(str(error)) from None
    if report is not None and figures is not None:
        _write_report(report, figures.result() | {"status": status.snapshot(frames / wish.film_fps)})


def mixed_sound(
    loaded: LoadedShow,
    show: Show,
    music: FilmSound | None,
    click: bool | None = None,
    taps: bool | None = None,
    *,
    begin: float = 0.0,
) -> ShowSound | None:
    """The mixer of the sound of a film from `begin` [s] of the show; None if there is nothing to add to the music."""
    own = loaded.patch.sound
    click, taps = own.click if click is None else click, own.taps if taps is None else taps
    return ShowSound(show, music, click=click, taps=taps, begin=begin) if click or taps else None


def canvas(
    stack: contextlib.ExitStack, wish: Wish, loaded: LoadedShow, fine: bool, *, alpha: bool = False
) -> tuple[OffscreenTarget, Renderer]:
    """What is drawn into, and what draws; released with the stack. PersonError for what this driver cannot draw."""
    try:
        ctx = create_headless_context()
    except NoOpenGL as error:
        raise PersonError(str(error)) from None
    stack.callback(release_headless_context, ctx)
    try:
        target = OffscreenTarget(ctx, wish.size, alpha=alpha)
        stack.callback(target.release)
        quality = CARD if fine and not alpha else None
        renderer = Renderer(ctx, loaded.scene(), size=wish.size, quality=quality, patient=True, bare=alpha)
    except ValueError as error:
        raise PersonError(f"{error}") from None
    stack.callback(renderer.release)
    return target, renderer


def _journal(
    stack: contextlib.ExitStack,
    wish: Wish,
    loaded: LoadedShow,
    show: Show,
    tempo: float | None,
    engine: Engine,
    music: Path | None,
) -> JournalWriter | None:
    if wish.journal is None:
        return None
    try:
        journal = JournalWriter(wish.journal, loaded.header(show, tempo=tempo, music=music))
    except JournalError as error:
        raise PersonError(str(error)) from None
    stack.callback(lambda: journal.close(engine.ticks.index))
    return journal


def _status_file(stack: contextlib.ExitStack, wish: Wish, status: Status, clock: ManualClock) -> StatusFile | None:
    if wish.status_json is None:
        return None
    try:
        lines = StatusFile(wish.status_json, status)
    except OSError as error:
        raise PersonError(f"cannot write --status-json {wish.status_json}: {error.strerror}") from None
    stack.callback(lambda: lines.close(clock.now()))
    return lines


def progress_bar(console: Console) -> Progress:
    """A bar for the frames of a film."""
    return Progress(
        TextColumn("rendering"), BarColumn(), MofNCompleteColumn(), TextColumn("frames"), TimeRemainingColumn(),
        console=console,
    )  # fmt: skip


def _write_report(path: Path, figures: dict[str, Any]) -> None:
    try:
        path.write_text(json.dumps(figures, indent=1, default=_plain) + "\n", encoding="utf-8")
    except OSError as error:
        raise PersonError(f"cannot write the report {path}: {error.strerror}") from None


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"{type(value).__name__} in a report")
