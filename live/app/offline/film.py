"""Offline rendering of a show to a film, with an engine whose clock is set frame by frame.

Also parses film names and frame rates of the command line.
"""

import contextlib
import json
import math
import re
from collections import Counter
from fractions import Fraction
from pathlib import Path
from typing import Any, Final

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from live.app.launch_options import LaunchOptions
from live.app.live_recording import film_sound, film_writer
from live.app.services.midi_service import attach_midi_file
from live.app.session_audio import AudioChoice, make_map_clock, make_show_analysis, start_tempo
from live.app.session_records import resident_megabytes
from live.base.errors import PersonError
from live.base.event_queue import EventQueue
from live.base.stage_snapshot import StageView
from live.clock.time_source import ManualClock
from live.control.audio.music_file import OfflineMusic
from live.control.events.events import ControlEvent
from live.render.adaptive_quality import HARDWARE
from live.render.film.film_writer import FilmError
from live.render.film.streams import FilmSound
from live.render.headless import NoOpenGL, OffscreenTarget, create_headless_context, release_headless_context
from live.render.renderer import Renderer
from live.show.engine import Engine
from live.show.journal.journal import JournalError, JournalWriter
from live.show.journal.motion_report import MotionReport
from live.show.loader import LoadedShow
from live.show.show import Show
from live.show.sound.soundtrack import Soundtrack
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
) -> None:
    """Render `seconds` of the show to `path`; with `report`, write motion figures as JSON.

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
    engine = Engine(show, clock=clock, inbox=inbox, status=status, stall=math.inf)
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
    frames = max(1, math.ceil(seconds * options.film_fps))
    figures = MotionReport(show) if report is not None else None
    heard = film_sound(sound.music)
    mixed = make_sound_mixer(loaded, show, heard, click, taps)
    with contextlib.ExitStack() as stack:
        target, renderer = make_renderer(stack, options, loaded, fine, alpha=alpha)
        writer = stack.enter_context(
            film_writer(
                path, size=options.size, fps=options.film_fps, sound=heard if mixed is None else mixed.film, alpha=alpha
            )
        )
        engine.journal = _journal(stack, options, loaded, show, tempo, engine, sound.path)
        lines = _status_file(stack, options, status, clock)

        def draw(view: StageView) -> None:
            renderer.draw(view, target.framebuffer)

        progress = stack.enter_context(progress_bar(console))
        task = progress.add_task("", total=frames)
        try:
            for frame in range(frames):
                now = frame / options.film_fps
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
        _write_report(report, figures.result() | {"status": status.snapshot(frames / options.film_fps)})


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
        quality = HARDWARE if fine and not alpha else None
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
) -> JournalWriter | None:
    if options.journal is None:
        return None
    try:
        journal = JournalWriter(options.journal, loaded.header(show, tempo=tempo, music=music))
    except JournalError as error:
        raise PersonError(str(error)) from None
    stack.callback(lambda: journal.close(engine.ticks.index))
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


PICTURES: Final = "%05d.png"
"""Name pattern of the pictures if the film is a folder."""
_NUMBER: Final = re.compile(r"%0?\d{0,2}d")
_FILM_ENDINGS: Final = (".mp4", ".mov", ".mkv")
_WITH_ALPHA: Final = (".mov", ".mkv")
_NTSC_FACTOR: Final = Fraction(1000, 1001)
"""NTSC factor: 59.94 is 60000/1001."""


def parse_film_path(path: Path, option: str, *, alpha: bool = False, inputs: list[str | None]) -> Path:
    """Return the film's path, with the name pattern of its pictures if it is a folder of PNG files.

    Raise PersonError for an unknown format, a format without alpha if `alpha` is set, a missing folder, and for the
    input files in `inputs`.
    """
    if path.is_dir() or (not path.suffix and "%" not in path.name):
        path = path / PICTURES
    if path.suffix.lower() == ".png":
        return _pictures(path, option)
    if path.suffix.lower() not in _FILM_ENDINGS:
        raise PersonError(
            f"{option} {path}: a film's name ends in {', '.join(_FILM_ENDINGS)}, or names a folder for PNG pictures",
            f"{option} {path.with_suffix('.mp4')}",
        )
    if alpha and path.suffix.lower() not in _WITH_ALPHA:
        raise PersonError(
            f"{option} {path}: {path.suffix} has no alpha; {', '.join(_WITH_ALPHA)} and folders of PNG pictures have",
            f"{option} {path.with_suffix('.mov')}",
        )
    if not path.parent.is_dir():
        raise PersonError(f"{option} {path}: there is no folder {path.parent}", f"mkdir -p {path.parent}")
    for other in inputs:
        if other is not None and path.exists() and Path(other).exists() and path.samefile(other):
            raise PersonError(f"{option} {path}: the show reads this file", "give the film another name")
    return path


def _pictures(path: Path, option: str) -> Path:
    if len(_NUMBER.findall(path.name)) != 1 or path.name.count("%") != 1:
        raise PersonError(
            f"{option} {path}: the pictures' name needs one number pattern such as %05d",
            f"{option} {path.parent / (path.stem.replace('%', '') + '-' + PICTURES)}",
        )
    if "%" in str(path.parent):
        raise PersonError(f"{option} {path}: the number pattern belongs in the pictures' name, not in the folder's")
    if path.parent.exists() and not path.parent.is_dir():
        raise PersonError(f"{option} {path}: {path.parent} is not a folder")
    if not path.parent.parent.is_dir():
        raise PersonError(f"{option} {path}: there is no folder {path.parent.parent}", f"mkdir -p {path.parent}")
    return path


def parse_rate(text: str | None, option: str = "--fps") -> float | None:
    """Parse frames per second, 1 to 480: 60, 59.94 (60000/1001) or a fraction such as 24000/1001; None for None."""
    if text is None:
        return None
    try:
        rate = Fraction(text.strip())
    except (ValueError, ZeroDivisionError):
        raise PersonError(f"{option} {text!r}: frames per second expected", f"{option} 60 or {option} 59.94") from None
    if not 1 <= rate <= 480:
        raise PersonError(f"{option} {text}: 1 to 480 expected")
    named = round(rate / _NTSC_FACTOR) * _NTSC_FACTOR
    if "/" not in text and rate.denominator > 1 and abs(rate - named) < Fraction(1, 200):
        rate = named
    return float(rate)
