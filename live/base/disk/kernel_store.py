"""Compiled kernels on disk: a folder per kernel set, a file per kernel, named by the content of its sources.

A *kernel set* is code of one Python minor version, numba, llvmlite and processor. `jit` decides which set a process
uses; this module keeps the files: checked when they are read, replaced atomically, private to their user.
"""

import contextlib
import hashlib
import os
import re
import shutil
import stat
import tempfile
import time
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import BinaryIO, Final

import platformdirs

from live.base.system.file_lock import lock_file
from live.base.system.files import user_number

_PACKAGE = Path(__file__).resolve().parents[2]
_MAGIC: Final = b"live kernel 1\n"
_KEEP_S: Final = 30 * 86_400.0
"""Kernels of other sources stay so long after they were written [s]: other checkouts may use them."""

_ARRAYS = re.compile(r"[a-z_-]+-[0-9a-f]{16}\.npz")
_IMPORT = re.compile(r"^from (live\.[\w.]+) import", re.MULTILINE)

_SHOW: Final = "show"
"""Name of the file that a running show locks."""
_TEMPORARY: Final = "choreographics-live-kernels-"
"""Beginning of the names of folders among the temporary files."""

SHIPPED_PACKAGE: Final = "choreographics_live_kernels"
"""Package of the companion wheel: it holds folders of kernel sets and nothing else."""

_LEVELS: Final[Mapping[str, frozenset[str]]] = {
    "x86-64-v4": frozenset(("avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl")),
    "x86-64-v3": frozenset(("avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe")),
}
"""Processor levels for which kernels are shipped, best first, and the features that each adds to the next."""


def kernel_files() -> list[Path]:
    """Return all files with kernels, in a fixed order: every ``*kernels.py`` of the package."""
    return sorted(_PACKAGE.rglob("*kernels.py"))


def sources_of(path: Path) -> list[Path]:
    """Return a file of kernels and all files whose code or constants are compiled into them, in a fixed order.

    Imports of kernel files are followed recursively. Of any other file only the text counts, as kernels take only
    constants from there.
    """
    found: set[Path] = set()
    waiting = [path]
    while waiting:
        file = waiting.pop()
        if file in found or not file.is_file():
            continue
        found.add(file)
        if file.stem.endswith("kernels"):
            modules = _IMPORT.findall(_text(file).decode())
            waiting += [_PACKAGE.parent.joinpath(*module.split(".")).with_suffix(".py") for module in modules]
    return sorted(found)


@cache
def _text(path: Path) -> bytes:
    return path.read_bytes()


@cache
def content_name(path: Path) -> str:
    """Return the name under which the kernels of one file are kept: its module and a hash of all its sources."""
    digest = hashlib.sha256()
    for source in sources_of(path):
        digest.update(_text(source))
    inside = path.relative_to(_PACKAGE) if path.is_relative_to(_PACKAGE) else Path(path.name)  # a bench's kernel is not
    name = ".".join(inside.with_suffix("").parts)
    return f"{name}-{digest.hexdigest()[:16]}"


@cache
def content_digest() -> str:
    """Return a hash of the sources of all kernels of the package."""
    names = "\n".join(content_name(path) for path in kernel_files())
    return hashlib.sha256(names.encode()).hexdigest()[:16]


def processor_levels(features: Mapping[str, bool]) -> list[str]:
    """Return the levels of x86-64 that a processor with these features has and for which kernels are shipped."""
    found: list[str] = []
    for level, added in reversed(list(_LEVELS.items())):
        if not all(features.get(name) for name in added):
            break
        found.insert(0, level)
    return found


def cache_root() -> Path:
    """Return the folder for compiled kernels; `LIVE_CACHE_DIR` overrides the user's cache directory."""
    return Path(os.environ.get("LIVE_CACHE_DIR") or platformdirs.user_cache_dir("choreographics-live")) / "kernels"


def make_private(folder: Path) -> bool:
    """Make a folder that only this user can write; return whether it is one.

    Kernels are machine code: nobody else may put files here. A folder of somebody else's, or a link to one, is refused;
    one of this user's that others could write is closed to them.
    """
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        user = user_number()
        if user is not None:
            found = folder.lstat() if folder.parent == Path(tempfile.gettempdir()) else folder.stat()
            if not stat.S_ISDIR(found.st_mode) or found.st_uid != user:
                return False
            if found.st_mode & 0o022:
                folder.chmod(0o700)
        return os.access(folder, os.W_OK)
    except OSError:
        return False


@cache
def writable_root() -> Path:
    """Return `cache_root`, or a private folder among the temporary files where it cannot be written.

    A show starts with a read-only home, too; it compiles again after the next start of the machine. Where nothing can
    be written at all the folder stays as it is, and each process compiles for itself.
    """
    root = cache_root()
    if make_private(root):
        return root
    try:
        root = _temporary_root()
    except OSError:  # there is no folder that can be written
        return root
    if make_private(root):
        return root
    try:
        return Path(tempfile.mkdtemp(prefix=_TEMPORARY))
    except OSError:
        return cache_root()


def _temporary_root() -> Path:
    user = user_number()
    return Path(tempfile.gettempdir()) / f"{_TEMPORARY}{'user' if user is None else user}"


def clear_cache() -> list[Path]:
    """Remove all that this user's shows keep in caches, and a folder that is empty then; return what went.

    Compiled kernels (here and among the temporary files) and arrays (`array_cache`); all of it is made anew when it is
    needed. Files of others stay, and links. BlockingIOError while a show runs; OSError if something cannot be removed.
    """
    root = cache_root()
    folders = [root]
    with contextlib.suppress(OSError):  # there is no folder for temporary files
        folders += sorted(Path(tempfile.gettempdir()).glob(f"{_TEMPORARY}*"))
    folders = [path for path in folders if _is_own(path) and path.is_dir()]
    arrays = [path for path in root.parent.glob("*.npz") if _ARRAYS.fullmatch(path.name) and _is_own(path)]
    with contextlib.ExitStack() as locks:  # no show begins meanwhile
        for folder in folders:
            lock_file(locks.enter_context((folder / _SHOW).open("wb")))
        for path in [*arrays, *(path for folder in folders for path in folder.iterdir() if path.name != _SHOW)]:
            if path.is_dir() and not path.is_symlink():
                shutil.rmtree(path)
            else:
                path.unlink()
    for folder in folders:  # Windows removes no open file
        shutil.rmtree(folder)
    with contextlib.suppress(OSError):  # it holds files of others, or there is none
        root.parent.rmdir()
    return folders + arrays


def _is_own(path: Path) -> bool:
    """Whether this is there, no link, and this user's."""
    try:
        found = path.lstat()
    except OSError:
        return False
    return not stat.S_ISLNK(found.st_mode) and user_number() in (None, found.st_uid)


def shipped_folder(set_name: str) -> Path | None:
    """Return the folder of a shipped kernel set that is complete for the present sources, or None."""
    spec = find_spec(SHIPPED_PACKAGE)
    for place in (spec.submodule_search_locations or ()) if spec else ():
        folder = Path(place) / set_name
        if KernelStore((folder,)).is_complete():
            return folder
    return None


TAKE_TIMEOUT: Final = 2.0
"""Longest wait of a show that begins [s] for those who look whether one runs, or clear the cache."""


class ShowLock:
    """Says to other processes of this user that a show runs, so that nobody compiles beside it."""

    def __init__(self) -> None:
        self._file: BinaryIO | None = None

    def take(self) -> None:
        """Say so until `release`, or until this process ends; several shows may."""
        with contextlib.suppress(OSError):
            self._file = (writable_root() / _SHOW).open("wb")
            lock_file(self._file, shared=True, within=TAKE_TIMEOUT)

    def release(self) -> None:
        """Say so no more."""
        if self._file is not None:
            self._file.close()
            self._file = None

    @staticmethod
    def is_taken() -> bool:
        """Whether a show runs."""
        with contextlib.suppress(OSError), (writable_root() / _SHOW).open("wb") as file:
            try:
                lock_file(file)
            except BlockingIOError:
                return True
        return False


class KernelStore:
    """Folders with the compiled kernels of one set; `folders`: those before the last are only read."""

    def __init__(self, folders: tuple[Path, ...]) -> None:
        self.folders = folders

    @property
    def own(self) -> Path:
        """The folder that is written."""
        return self.folders[-1]

    def read(self, name: str) -> bytes | None:
        """Return what `write` was given under this name; None if it is missing, cut short or damaged."""
        for folder in self.folders:
            with contextlib.suppress(OSError):
                data = (folder / name).read_bytes()
                begin = len(_MAGIC) + 32
                if data.startswith(_MAGIC) and hashlib.sha256(data[begin:]).digest() == data[len(_MAGIC) : begin]:
                    return data[begin:]
        return None

    def has(self, name: str) -> bool:
        """Whether a file of this name exists (its content is checked only when it is read)."""
        return any((folder / name).is_file() for folder in self.folders)

    def write(self, name: str, data: bytes) -> None:
        """Replace a file atomically; a full or read-only disk is no error, the kernel is compiled again next time."""
        with contextlib.suppress(OSError):
            if make_private(self.own):
                self._replace(name, _MAGIC + hashlib.sha256(data).digest() + data)

    def _replace(self, name: str, data: bytes) -> None:
        handle, temporary = tempfile.mkstemp(dir=self.own, prefix=".", suffix=".part")
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(data)
            os.replace(temporary, self.own / name)
        except BaseException:
            with contextlib.suppress(OSError):
                os.unlink(temporary)
            raise

    @property
    def complete_mark(self) -> Path:
        """The file that says that all kernels of the present sources are in `own`."""
        return self.own / f"complete-{content_digest()}"

    def is_complete(self) -> bool:
        """Whether `mark_complete` was called for the present sources, in any of the folders."""
        return any((folder / self.complete_mark.name).exists() for folder in self.folders)

    def mark_complete(self, names: Iterable[str]) -> None:
        """Say that all kernels of the present sources, `names`, are there, if they are."""
        if all(self.has(name) for name in names):
            with contextlib.suppress(OSError):
                make_private(self.own)
                self.complete_mark.touch()

    def drop_old(self) -> None:
        """Remove kernels of other sources that were written long ago."""
        current = {content_name(path) for path in kernel_files()} | {self.complete_mark.name}
        before = time.time() - _KEEP_S
        with contextlib.suppress(OSError):
            for entry in os.scandir(self.own):
                with contextlib.suppress(OSError):
                    if entry.name.partition("/")[0].rpartition(".")[0] in current or entry.name in current:
                        continue
                    if entry.is_file(follow_symlinks=False) and entry.stat().st_mtime < before:
                        os.unlink(entry.path)

    @contextlib.contextmanager
    def compiling(self, name: str) -> Iterator[None]:
        """Hold the right to compile one kernel; wait while another process compiles it.

        A process that ends lets go of it. Look again into the store afterwards. Without a disk to lock on, go on.
        """
        file = None
        with contextlib.suppress(OSError):
            if make_private(self.own / "locks"):
                file = (self.own / "locks" / name).open("wb")
                lock_file(file, within=None)
        try:
            yield
        finally:
            if file is not None:
                file.close()
