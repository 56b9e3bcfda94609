"""A film of a journal, drawn in one go or in parts by several workers, with its sound."""

import contextlib
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numpy as np
from rich.console import Console

from live.app.film.film_crew import Crew, LocalCrew, PartResult
from live.app.film.film_plan import FilmPart, FilmPlan, film_frames, part_bounds
from live.app.film.film_worker import FilmOrder, needed_files
from live.app.film.live_recording import film_sound
from live.app.film.replay_film import FilmLook, film_replay, journal_music, music_from
from live.app.film.show_film import make_sound_mixer, progress_bar
from live.base.errors import PersonError
from live.base.stage_snapshot import StageView
from live.clock.ticks import FrameGrid
from live.render.film.film_parts import join_parts, write_sound
from live.render.film.film_writer import FilmError
from live.render.film.streams import ENCODER_THREADS, FilmSound, Samples
from live.show.journal.journal_reader import Journal
from live.show.journal.replay import ReplayResult
from live.show.loader import LoadedShow
from live.show.show import Show
from live.show.sound.soundtrack import Soundtrack

MORE_PATIENCE: Final = 4.0
"""A part whose pictures do not continue those before is drawn again, with so many times the memory."""


def film_journal(
    journal: Journal,
    loaded: LoadedShow,
    path: Path,
    look: FilmLook,
    *,
    measures: tuple[int, int | None] = (1, None),
    frames: tuple[int, int | None] | None = None,
    workers: int | None = None,
    cluster: str | None = None,
    problems: list[str],
    console: Console,
    threads: int = ENCODER_THREADS,
    on_drawn: Callable[[int], None] = lambda count: None,
) -> ReplayResult:
    """Render a journal to `path`: `measures` or `frames` of it (see `film_frames`), by so many `workers` on this
    machine, or by a Dask `cluster`. Return how its hashes compare. Raise PersonError if rendering fails.

    `threads`: of each encoder in parts. `on_drawn` is told how many more frames are drawn, fewer if a worker was lost.
    """
    first, end, total = film_frames(journal, loaded, look.grid, measures=measures, frames=frames, problems=problems)
    if workers is None and cluster is None:
        result, made = film_replay(
            journal, loaded, path, look, (first, end), to_end=end == total, problems=problems, console=console,
            on_drawn=on_drawn,
        )  # fmt: skip
        console.print(made, soft_wrap=True, markup=False)
        return result
    with contextlib.ExitStack() as stack:
        folder = _parts_folder(stack, path)
        order = FilmOrder(
            str(journal.path.absolute()), str(path.absolute()), look.size, look.grid.fps, look.fine, look.alpha, threads
        )
        crew: Crew
        if cluster is None:
            count = workers or 1
            bounds = part_bounds(first, end, count, look.grid.fps)
            crew = LocalCrew(order, folder, min(count, len(bounds) - 1))
        else:
            from live.app.film.film_cluster import ClusterCrew

            needs = needed_files(journal, loaded)
            found = ClusterCrew(cluster, order, needs, folder, journal.path, console)
            bounds = part_bounds(first, end, workers or found.size, look.grid.fps)
            crew = found
        stack.callback(crew.close)
        film = _PartedFilm(journal, loaded, path, look, bounds, folder, crew, on_drawn)
        result = film.make(console, problems, to_end=end == total)
    console.print(f"the film is here: {path.resolve()}", soft_wrap=True, markup=False)
    return result


def _parts_folder(stack: contextlib.ExitStack, path: Path) -> Path:
    """Return a folder for the parts, on the film's disk, that is removed at the end."""
    try:
        if path.suffix.lower() == ".png":
            path.parent.mkdir(exist_ok=True)
        return Path(stack.enter_context(tempfile.TemporaryDirectory(prefix=f".{path.stem[:32]}-", dir=path.parent)))
    except OSError as error:
        raise PersonError(f"{path}: the film cannot be written: {error.strerror}") from None


class _PartedFilm:
    """Plans a film, has its parts drawn, compares where they meet, and joins them."""

    def __init__(
        self,
        journal: Journal,
        loaded: LoadedShow,
        path: Path,
        look: FilmLook,
        bounds: list[int],
        folder: Path,
        crew: Crew,
        on_drawn: Callable[[int], None],
    ) -> None:
        self._journal, self._loaded, self._path, self._look = journal, loaded, path, look
        self._bounds, self._folder, self._crew, self._on_drawn = bounds, folder, crew, on_drawn
        self._parts: dict[int, FilmPart] = {}
        self._done: dict[int, PartResult] = {}

    def make(self, console: Console, problems: list[str], *, to_end: bool) -> ReplayResult:
        """Make the film; return how the hashes of its states compare. PersonError if it cannot be made."""
        music, grid = journal_music(self._journal), self._look.grid
        sound = _PlannedSound(self._loaded, film_sound(music), grid, self._folder / "sound")
        plan = FilmPlan(
            self._journal, self._loaded, grid, self._bounds, problems=problems, to_end=to_end,
            on_frame=sound.frame if sound.is_mixed else None,
        )  # fmt: skip
        with progress_bar(console) as progress:
            task = progress.add_task("", total=self._bounds[-1] - self._bounds[0])
            for part in plan.parts():
                if part is not None:
                    self._parts[part.number] = part
                    self._crew.add(part)
                self._take(progress, task, wait=False)
            result = plan.result
            assert result is not None
            self._finish(progress, task)
            patience = MORE_PATIENCE
            while wrong := self._wrong():
                self._draw_again(wrong, patience, problems, to_end=to_end)
                self._finish(progress, task)
                patience *= MORE_PATIENCE
        begin = grid.time(self._bounds[0])
        self._join(sound.film() if sound.is_mixed else music_from(music, begin))
        return result

    def _take(self, progress: Any, task: Any, *, wait: bool) -> None:
        for found in self._crew.poll(wait=wait):
            if isinstance(found, PartResult):
                self._done[found.number] = found
            else:
                progress.advance(task, found)
                self._on_drawn(found)

    def _finish(self, progress: Any, task: Any) -> None:
        while self._crew.busy:
            self._take(progress, task, wait=True)

    def _wrong(self) -> list[int]:
        """Return the parts that do not continue the one before, up to the first one whose predecessor is among them."""
        done = self._done
        apart = [number for number in range(1, len(done)) if done[number].before != done[number - 1].last]
        return [number for number in apart if number - 1 not in apart]

    def _draw_again(self, numbers: list[int], patience: float, problems: list[str], *, to_end: bool) -> None:
        for number in numbers:
            if self._parts[number].reach.draw == 0:
                raise PersonError(
                    f"frame {self._parts[number].first - 1} is not the same when it is drawn again",
                    "draw the film by one process: leave out --workers and --cluster",
                )
        plan = FilmPlan(
            self._journal, self._loaded, self._look.grid, self._bounds[: max(numbers) + 2], problems=[], to_end=to_end
        )
        for part in plan.parts(patience=patience, whole=False):
            if part is not None and part.number in numbers:
                self._parts[part.number] = part
                self._crew.add(part)

    def _join(self, sound: FilmSound | None) -> None:
        look, path = self._look, self._path
        try:
            if path.suffix.lower() != ".png":
                parts = [(self._crew.file_of(part), part.count) for _, part in sorted(self._parts.items())]
                join_parts(path, parts, size=look.size, fps=look.grid.fps, sound=sound, alpha=look.alpha)
            elif sound is not None:
                write_sound(path, sound, self._bounds[-1] - self._bounds[0], look.grid.fps)
        except FilmError as error:
            raise PersonError(str(error)) from None


class _PlannedSound:
    """The sound of a film with click or taps, mixed while the film is planned, once for all parts."""

    def __init__(self, loaded: LoadedShow, music: FilmSound | None, grid: FrameGrid, path: Path) -> None:
        self._loaded, self._music, self._grid, self._path = loaded, music, grid, path
        self.is_mixed = loaded.patch.sound.click or loaded.patch.sound.taps
        self._mixed: Soundtrack | None = None
        self._view: StageView | None = None

    def frame(self, show: Show, frame: int) -> None:
        """Mix the sound up to a frame."""
        if self._mixed is None or self._view is None:
            self._mixed = make_sound_mixer(self._loaded, show, self._music, begin=self._grid.time(frame))
            self._view = show.view()
        assert self._mixed is not None
        show.fill(self._view, max(self._grid.time(frame), show.time))
        self._mixed.frame(self._view)
        with self._path.open("ab") as file:
            file.write(self._mixed.film.read(0, 1 << 30).tobytes())

    def film(self) -> FilmSound:
        """Return all of it."""
        assert self._mixed is not None
        samples = np.memmap(self._path, np.float32, "r").reshape(-1, 2)

        def read(first: int, count: int) -> Samples:
            return np.array(samples[first : first + count])

        return FilmSound(self._mixed.film.rate, 2, read)
