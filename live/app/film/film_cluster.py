"""Workers of a Dask cluster that draw the parts of a film.

Dask sends functions and values between its own processes as pickles, so the cluster must be one's own: whoever reaches
its scheduler can run code on all of it. Each part is drawn in a process of its own beside the Dask worker.
"""

import contextlib
import tempfile
import warnings
import zlib
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import asdict, replace
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any, Final

from rich.console import Console

from live.app.film.film_crew import MAX_TRIES, WAIT_S, PartResult
from live.app.film.film_plan import FilmPart
from live.app.film.film_worker import FilmOrder, FilmWorker, WorkerEnded, draw_alone
from live.base.errors import PersonError
from live.base.system.process_control import processor_count

CONNECT_TIMEOUT_S: Final = 10.0


def check_worker(order: dict[str, Any], journal: bytes) -> dict[str, str]:
    """Run on a worker: return `{"gl": …}`, the name of its OpenGL driver, or `{"refused": …}`, why it cannot draw the
    film."""
    with tempfile.TemporaryDirectory() as folder:
        heard: SimpleQueue[tuple[FilmWorker, dict[str, Any]]] = SimpleQueue()
        try:
            worker = FilmWorker(_order_here(order, journal, Path(folder)), heard, threads=processor_count())
        except PersonError as error:
            return {"refused": str(error)}
        try:
            _, message = heard.get()
        finally:
            worker.close()
    if "ready" in message:
        return {"gl": str(message["ready"]["gl"])}
    return {"refused": str(message.get("refused", message.get("ended", "")))}


class PartFailed(Exception):
    """A worker could not draw a part; others may."""

    def __init__(self, worker: str, why: str) -> None:
        """`worker`: its address; empty if it is not known."""
        super().__init__(worker, why)
        self.worker, self.why = worker, why

    def __str__(self) -> str:
        return self.why


def draw_remote(
    order: dict[str, Any], journal: bytes, part: FilmPart, at_a_time: int
) -> tuple[dict[str, str], dict[str, bytes]]:
    """Run on a worker: draw a part; return the hashes of its pictures (`PartResult`), and the files. `at_a_time`: so
    many parts are drawn on this machine, and share its processors.

    PartFailed if it cannot be drawn here: the process that drew it has ended, or the disk is full.
    """
    try:
        return _draw_here(order, journal, part, at_a_time)
    except (PersonError, WorkerEnded, OSError) as error:
        raise PartFailed(_this_worker(), str(error)) from None


def _this_worker() -> str:
    """Return the address of the Dask worker that runs this."""
    from distributed import get_worker

    with contextlib.suppress(ValueError):  # there is none
        return str(get_worker().address)
    return ""


def _draw_here(
    order: dict[str, Any], journal: bytes, part: FilmPart, at_a_time: int
) -> tuple[dict[str, str], dict[str, bytes]]:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        here = _order_here(order, journal, folder)
        snapshot, out = None, folder / "out"
        if part.snapshot is not None:
            snapshot = folder / "snapshot"
            snapshot.write_bytes(part.snapshot)
        if here.film.endswith(".png"):
            out.mkdir()
        done: dict[str, Any] = {}
        for message in draw_alone(here, part, out, snapshot, threads=max(processor_count() // at_a_time, 1)):
            done = message
        files = sorted(out.iterdir()) if out.is_dir() else [out]
        return {key: str(done[key]) for key in ("before", "last")}, {file.name: file.read_bytes() for file in files}


def _order_here(order: dict[str, Any], journal: bytes, folder: Path) -> FilmOrder:
    """Return the order with its files in a folder of this machine."""
    path = folder / "journal"
    path.write_bytes(zlib.decompress(journal))
    there = FilmOrder(**order)
    return replace(there, journal=str(path), film=str(folder / Path(there.film).name.lower()))


class ClusterCrew:
    """Workers of a Dask cluster; see `Crew`. Thread: one."""

    def __init__(
        self,
        address: str,
        order: FilmOrder,
        needs: tuple[tuple[str, str, str], ...],
        folder: Path,
        journal: Path,
        console: Console,
    ) -> None:
        """`needs`: files that each worker must have (`needed_files`). Workers that cannot draw the film are named on
        `console` and left out. PersonError if none is left, or there is no cluster."""
        self._client = _connect(address)
        self._film, self._folder = Path(order.film), folder
        self._order, self._journal = asdict(replace(order, needs=needs)), zlib.compress(journal.read_bytes(), 6)
        self._tries: dict[int, int] = {}
        self._failed: dict[int, set[str]] = {}
        self._futures: dict[Any, FilmPart] = {}
        self._ended: SimpleQueue[Any] = SimpleQueue()
        try:
            self._threads = self._accept(console)
        except BaseException:
            self._client.close()
            raise

    @property
    def size(self) -> int:
        """How many parts are drawn at a time."""
        return sum(self._threads.values())

    def _accept(self, console: Console) -> dict[str, int]:
        """Return the workers that can draw the film, with their numbers of threads."""
        found: Mapping[str, Any] = self._client.scheduler_info(n_workers=-1)["workers"]
        if not found:
            raise PersonError("--cluster: the cluster has no worker", "dask worker tcp://HOST:8786 on each machine")
        checks = {
            worker: self._client.submit(check_worker, self._order, self._journal, workers=[worker], pure=False)
            for worker in found
        }
        told: dict[str, dict[str, str]] = {}
        for worker, future in checks.items():
            try:
                told[worker] = future.result()
            except Exception as error:  # the package is missing there, or the worker has gone
                told[worker] = {"refused": str(error) or type(error).__name__}
        drivers = Counter(facts["gl"] for facts in told.values() if "gl" in facts)
        usual = drivers.most_common(1)[0][0] if drivers else ""
        accepted = {}
        for worker, facts in told.items():
            why = facts.get("refused", "")
            if not why and facts["gl"] != usual:
                why = f"its OpenGL driver is {facts['gl']}, that of others {usual}: pictures would differ"
            if why:
                console.print(f"worker {worker} is left out: {why}", style="yellow", soft_wrap=True, markup=False)
            else:
                accepted[worker] = int(found[worker]["nthreads"])
        if not accepted:
            raise PersonError("--cluster: no worker can draw this film; why is said above")
        return accepted

    def add(self, part: FilmPart) -> None:
        """See `Crew`."""
        failed = self._failed.get(part.number, set())
        workers = [worker for worker in self._threads if worker not in failed] or list(self._threads)
        future = self._client.submit(
            draw_remote, self._order, self._journal, part, max(self._threads.values()),
            workers=workers, pure=False, priority=-part.number,
        )  # fmt: skip
        self._futures[future] = part
        future.add_done_callback(self._ended.put)

    @property
    def busy(self) -> bool:
        """See `Crew`."""
        return bool(self._futures)

    def poll(self, *, wait: bool) -> Iterator[int | PartResult]:
        """See `Crew`."""
        while True:
            try:
                future = self._ended.get(timeout=WAIT_S) if wait else self._ended.get_nowait()
            except Empty:
                return
            wait = False
            part = self._futures.pop(future)
            try:
                hashes, files = future.result()
            except Exception as error:  # its worker has gone, or cannot draw it
                self._lost(part, error)
                continue
            self._store(part, files)
            yield part.count
            yield PartResult(part.number, hashes["before"], hashes["last"])

    def _lost(self, part: FilmPart, error: Exception) -> None:
        self._tries[part.number] = tries = self._tries.get(part.number, 0) + 1
        if tries >= MAX_TRIES:
            words = f"frames {part.first} to {part.end - 1} could not be drawn by {tries} workers"
            raise PersonError(f"{words}: {error}") from None
        if isinstance(error, PartFailed):
            self._failed.setdefault(part.number, set()).add(error.worker)
        self.add(part)

    def _store(self, part: FilmPart, files: dict[str, bytes]) -> None:
        """Write the files of a part: pictures into the film's folder."""
        pictures = self._film.suffix.lower() == ".png"
        expected = {(self._film.name % frame).lower() for frame in range(part.first, part.end)} if pictures else {"out"}
        if set(files) != expected:
            raise PersonError(f"the cluster returned other files than those of frames {part.first} to {part.end - 1}")
        try:
            if not pictures:
                self.file_of(part).write_bytes(files["out"])
            else:
                for frame in range(part.first, part.end):
                    name = self._film.name % frame
                    (self._film.parent / name).write_bytes(files[name.lower()])
        except OSError as error:
            raise PersonError(f"{self._film}: the film cannot be written: {error.strerror}") from None

    def file_of(self, part: FilmPart) -> Path:
        """See `Crew`."""
        return self._folder / f"{part.number}.part"

    def close(self) -> None:
        """See `Crew`; the cluster goes on for others."""
        self._client.cancel(list(self._futures))
        self._client.close()


def _connect(address: str) -> Any:
    """Return a client of a cluster; PersonError if there is none."""
    try:
        from distributed import Client
    except ImportError:
        raise PersonError(
            "--cluster needs the package distributed", "pip install 'choreographics-live[cluster]'"
        ) from None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # other versions of packages there: each worker is asked for its own
            return Client(address, timeout=CONNECT_TIMEOUT_S, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        raise PersonError(
            f"--cluster {address}: no Dask scheduler answers: {error}", "dask scheduler --host 127.0.0.1"
        ) from None
