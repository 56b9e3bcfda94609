"""A process that draws parts of a film, seen from the one that wants the film: what it is told, and what it answers."""

import contextlib
import hashlib
import json
import os
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from queue import SimpleQueue
from typing import Any, Final

from live import __version__
from live.app.film.film_plan import FilmPart
from live.base.errors import PersonError
from live.base.jit import KERNEL_SET
from live.base.system.process_control import own_session
from live.render.film.picture_memory import Reach
from live.render.film.streams import ENCODER_THREADS
from live.show.journal.journal_reader import Journal
from live.show.loader import LoadedShow

_MODULE: Final = "live.app.processes.film_worker_main"
_BLOCK: Final = 1 << 20


@dataclass(frozen=True, slots=True)
class FilmOrder:
    """A film, as its workers are told it; all values go through JSON."""

    journal: str
    """Path of the journal."""
    film: str
    """Path of the whole film; its ending selects the format."""
    size: tuple[int, int]
    fps: float
    fine: bool = False
    alpha: bool = False
    threads: int = ENCODER_THREADS
    """Threads of each encoder; other numbers give other packets."""
    version: str = __version__
    kernels: str = KERNEL_SET
    needs: tuple[tuple[str, str, str], ...] = ()
    """Files that the pictures need: what each is, its path and the hash of its content."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "size", tuple(self.size))
        object.__setattr__(self, "needs", tuple(tuple(need) for need in self.needs))


def needed_files(journal: Journal, loaded: LoadedShow) -> tuple[tuple[str, str, str], ...]:
    """Return what a worker on another machine needs of a show beside package and steps: music, fonts, images, videos,
    set pieces and characters. PersonError if one cannot be read here."""
    scene = loaded.scene()
    music = journal.header.get("music")
    named = [("music", str(music))] if music is not None else []
    named += [("font", path) for _, path in scene.fonts]
    named += [("background", each.file) for each in scene.backgrounds if each.file and "#" not in each.file]
    named += [("set piece", each.file) for each in scene.scenery]
    named += [("character", each.path) for each in scene.characters]
    needs = []
    for what, path in dict.fromkeys(named):
        try:
            needs.append((what, path, _file_hash(Path(path))))
        except OSError as error:
            raise PersonError(f"the {what} {path} cannot be read: {error.strerror}") from None
    return tuple(needs)


def check_needs(order: FilmOrder) -> None:
    """Raise PersonError, which names what differs, if this process cannot draw what the order asks for."""
    if order.version != __version__:
        raise PersonError(f"its version is {__version__}, the film's {order.version}", "install the same version there")
    if order.kernels != KERNEL_SET:
        raise PersonError(
            f"its kernels are {KERNEL_SET}, the film's {order.kernels}: states would differ",
            "use the same versions of numba and numpy on processors of the same kind",
        )
    for what, path, known in order.needs:
        try:
            found = _file_hash(Path(path))
        except OSError as error:
            raise PersonError(f"the {what} {path} is missing: {error.strerror}", "copy it to the same path") from None
        if found != known:
            raise PersonError(f"the {what} {path} is another file", "copy it from the machine that asks for the film")


def _file_hash(path: Path) -> str:
    found = hashlib.blake2b(digest_size=16)
    with path.open("rb") as file:
        while block := file.read(_BLOCK):
            found.update(block)
    return found.hexdigest()


def part_to_json(part: FilmPart, out: Path, snapshot: Path | None) -> dict[str, Any]:
    """Return the message that asks for a part; its snapshot is in a file."""
    return {
        "number": part.number, "first": part.first, "end": part.end, "follow": part.reach.follow,
        "draw": part.reach.draw, "titles": part.titles, "out": str(out),
        "snapshot": None if snapshot is None else str(snapshot),
    }  # fmt: skip


def part_from_json(asked: dict[str, Any]) -> FilmPart:
    """Return the part that a message asks for."""
    snapshot = None if asked["snapshot"] is None else Path(asked["snapshot"]).read_bytes()
    titles = tuple((text, font) for text, font in asked["titles"])
    reach = Reach(asked["follow"], asked["draw"])
    return FilmPart(asked["number"], asked["first"], asked["end"], reach, snapshot, titles)


class FilmWorker:
    """A started process that draws parts of a film, one at a time. Thread: one; another one reads its messages."""

    def __init__(
        self, order: FilmOrder, heard: "SimpleQueue[tuple[FilmWorker, dict[str, Any]]]", *, threads: int
    ) -> None:
        """`heard` gets its messages, `{"ended": …}` as the last one. `threads`: of a driver that draws in software.
        PersonError if it cannot be started."""
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 (closed with the process)
        quiet = {"OPENBLAS_NUM_THREADS": "1", "LP_NUM_THREADS": str(threads)}
        try:
            self.process = subprocess.Popen(
                [sys.executable, "-m", _MODULE],
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._errors, text=True,
                env=quiet | os.environ, **own_session(),
            )  # fmt: skip
        except OSError as error:
            self._errors.close()
            raise PersonError(f"a process for the film cannot be started: {error.strerror}") from None
        self.part: FilmPart | None = None
        """The part that it draws now."""
        self.ready = False
        """Whether it has loaded the show."""
        self._heard = heard
        self._reader = threading.Thread(target=self._read, name="film worker", daemon=True)
        self._reader.start()
        self._send(asdict(order))

    def _read(self) -> None:
        """Hand on its messages. A line that is none ends it. Whoever waits always hears of its end."""
        assert self.process.stdout is not None
        ended = ""
        try:
            for line in self.process.stdout:
                self._heard.put((self, json.loads(line)))
        except Exception as error:
            ended = f"it wrote what is no message: {error}"
            self.process.kill()
        self.process.wait()
        self._heard.put((self, {"ended": ended or self.last_words()}))

    def ask(self, part: FilmPart, out: Path, snapshot: Path | None) -> None:
        """Let it draw a part into `out`: a file, or a folder of pictures."""
        self.part = part
        self._send(part_to_json(part, out, snapshot))

    def _send(self, message: dict[str, Any]) -> None:
        assert self.process.stdin is not None
        with contextlib.suppress(OSError):  # it has ended, and the reader says so
            self.process.stdin.write(json.dumps(message) + "\n")
            self.process.stdin.flush()

    def last_words(self) -> str:
        """Return the last line that it wrote about an error, or how it ended."""
        self._errors.seek(0)
        lines = self._errors.read().decode("utf-8", "replace").split("\n")
        words = [line.strip() for line in lines if line.strip()]
        return words[-1] if words else f"exit status {self.process.returncode}"

    def close(self) -> None:
        """End the process."""
        self.process.kill()
        self._reader.join()
        for file in (self.process.stdin, self.process.stdout, self._errors):
            if file is not None:
                with contextlib.suppress(OSError):
                    file.close()


class WorkerEnded(Exception):
    """The process that drew a part has ended; the message is its last words."""


def draw_alone(
    order: FilmOrder, part: FilmPart, out: Path, snapshot: Path | None, *, threads: int
) -> Iterator[dict[str, Any]]:
    """Draw one part in a process of its own; yield its messages. PersonError if it is refused, WorkerEnded if the
    process ends."""
    heard: SimpleQueue[tuple[FilmWorker, dict[str, Any]]] = SimpleQueue()
    worker = FilmWorker(order, heard, threads=threads)
    try:
        worker.ask(part, out, snapshot)
        while True:
            _, message = heard.get()
            if "refused" in message:
                raise PersonError(str(message["refused"]))
            if "ended" in message:
                raise WorkerEnded(str(message["ended"]))
            yield message
            if "done" in message:
                return
    finally:
        worker.close()
