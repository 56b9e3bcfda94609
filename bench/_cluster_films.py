"""Films in parts: their pictures and their speed, for the bench of clusters."""

import os
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from queue import SimpleQueue
from typing import Any

from rich.console import Console

from live.app.film.film_plan import FilmPlan
from live.app.film.film_worker import FilmOrder, FilmWorker
from live.app.film.parted_film import film_journal
from live.app.film.replay_film import FilmLook
from live.app.film.show_film import film_show
from live.app.launch_options import LaunchOptions
from live.app.processes.film_worker_main import FilmDrawing
from live.app.session_audio import choose_audio
from live.base.system.process_control import processor_count
from live.cli.bench import Row
from live.clock.ticks import FrameGrid
from live.show.journal.journal_reader import Journal, read_journal
from live.show.journal.replay import load_journal
from live.show.loader import LoadedShow

SMALL, COUNTED = (64, 36), (480, 270)
FPS = 30.0
SHORT_S = 4.0
PARTS = (1, 2, 7)
QUIET = Console(quiet=True)


def film_rows(full: bool) -> list[Row]:
    """Return the rows of films in parts.

    Pictures are compared byte by byte. Speed is that of a film from its first frame on, without the start of processes;
    with `full` it is longer and drawn three times.
    """
    with tempfile.TemporaryDirectory() as folder:
        return [*_pictures(Path(folder)), *_speed(Path(folder), full=full)]


def _filmed(folder: Path, film: Path, size: tuple[int, int], seconds: float) -> tuple[Journal, LoadedShow]:
    """Film the first show; return its journal, and the show loaded from that."""
    options = LaunchOptions(size=size, fps=FPS, journal=folder / f"{film.stem}.jsonl")
    loaded = options.load()
    film_show(options, loaded, choose_audio(options, loaded), path=film, seconds=seconds, console=QUIET)
    assert options.journal is not None
    journal = read_journal(options.journal)
    return journal, load_journal(journal)


def _pictures(folder: Path) -> list[Row]:
    first = folder / "first"
    journal, loaded = _filmed(folder, first / "%05d.png", SMALL, SHORT_S)
    grid, frames = FrameGrid(FPS), round(SHORT_S * FPS)
    differ = {}
    with ExitStack() as stack:
        order = FilmOrder(str(journal.path), str(folder / "%05d.png"), SMALL, FPS)
        drawing = FilmDrawing(order, stack)
        for parts in PARTS:
            out = folder / f"of {parts}"
            bounds = [round(frames * part / parts) for part in range(parts + 1)]
            for part in FilmPlan(journal, loaded, grid, bounds, problems=[], to_end=True).parts():
                if part is not None:
                    drawing.draw(part, out, lambda message: None)
            differ[parts] = sum(
                (out / f"{frame:05d}.png").read_bytes() != (first / f"{frame:05d}.png").read_bytes()
                for frame in range(frames)
            )
    peers = {f"of {parts} part{'s' * (parts > 1)}": float(count) for parts, count in differ.items()}
    return [Row("pictures of films in parts that are not those of the first rendering",
                float(sum(differ.values())), "pictures", 0.0, peers=peers, note=f"of {frames} each")]  # fmt: skip


class _FirstFrame:
    """Notes when the first frame of a film was drawn."""

    def __init__(self) -> None:
        self.time: float | None = None

    def __call__(self, count: int) -> None:
        self.time = time.perf_counter() if self.time is None else self.time

    def since(self) -> float:
        """Return the time since then [s]."""
        assert self.time is not None
        return time.perf_counter() - self.time


@contextmanager
def _one_thread() -> Iterator[None]:
    """Hold drivers that draw in software, in processes started within, to the thread that draws: with 1 they would have
    another one beside it, which takes nearly as much, so that one worker alone filled two cores."""
    before = os.environ.get("LP_NUM_THREADS")
    os.environ["LP_NUM_THREADS"] = "0"
    try:
        yield
    finally:
        os.environ.pop("LP_NUM_THREADS")
        if before is not None:
            os.environ["LP_NUM_THREADS"] = before


def _by_workers(journal: Journal, loaded: LoadedShow, film: Path, workers: int, frames: int) -> tuple[float, float]:
    """Return the pictures a second of a film by so many workers of one thread each, and their processor time [s]."""
    begun, before = _FirstFrame(), _processor_time()
    with _one_thread():
        film_journal(
            journal, loaded, film, FilmLook(COUNTED, FrameGrid(FPS)), frames=(0, frames), workers=workers, problems=[],
            console=QUIET, threads=1, on_drawn=begun,
        )  # fmt: skip
    return frames / begun.since(), _processor_time() - before


def _processor_time() -> float:
    """Return the processor time of the children that have ended [s]."""
    return sum(os.times()[2:4])


def _start_time(journal: Journal, film: Path) -> float:
    """Return the processor time that a worker needs before its first part [s]."""
    heard: SimpleQueue[tuple[FilmWorker, dict[str, Any]]] = SimpleQueue()
    before = _processor_time()
    with _one_thread():
        worker = FilmWorker(FilmOrder(str(journal.path), str(film), COUNTED, FPS, threads=1), heard, threads=1)
        heard.get()
        worker.close()
    return _processor_time() - before


def _in_one_process(journal: Journal, loaded: LoadedShow, film: Path, frames: int) -> float:
    """Return the pictures a second of a film without workers: drawing has all cores, and so has the encoder."""
    begun, look = _FirstFrame(), FilmLook(COUNTED, FrameGrid(FPS))
    film_journal(journal, loaded, film, look, frames=(0, frames), problems=[], console=QUIET, on_drawn=begun)
    return frames / begun.since()


def _speed(folder: Path, *, full: bool) -> list[Row]:
    seconds = 32.0 if full else 8.0
    frames = round(seconds * FPS)
    # its motion is enough for the journal
    journal, loaded = _filmed(folder, folder / "show.csv", COUNTED, seconds)
    ratios: list[tuple[float, float]] = []
    rates: list[tuple[float, ...]] = []
    for turn in range(3 if full else 1):
        film = folder / f"{turn}.mp4"
        two, busy_two = _by_workers(journal, loaded, film, 2, frames)
        one, busy_one = _by_workers(journal, loaded, film, 1, frames)
        plain = _in_one_process(journal, loaded, film, frames)
        ratios.append((two / one, two / plain))
        rates.append((one, two, plain, busy_one, busy_two))
    middle = len(ratios) // 2
    over_one, over_plain = (sorted(column)[middle] for column in zip(*ratios, strict=True))
    one, two, plain, busy_one, busy_two = (sorted(column)[middle] for column in zip(*rates, strict=True))
    start = _start_time(journal, folder / "film.mp4")
    by_processor = 2.0 * (busy_one - start) / (busy_two - 2.0 * start)
    load = f"{processor_count()} cores, load {os.getloadavg()[0]:.1f}; {frames} frames of {COUNTED[0]} x {COUNTED[1]}"
    return [
        Row("film by 2 workers over 1, one thread each", over_one, "times", 1.8, "at least",
            {"1 worker, pictures/s": one, "2 workers, pictures/s": two,
             "by processor time, as on free cores": by_processor}, load),
        Row("film by 2 workers over one process with all cores", over_plain, "times", 1.1, "at least",
            {"one process, pictures/s": plain}, load),
    ]  # fmt: skip
