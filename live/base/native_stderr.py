"""Silence for C libraries that write to stderr by themselves (ALSA, JACK and Mesa on a machine without hardware), and
streams that outlive the terminal they lead to."""

import contextlib
import io
import os
import sys
from collections.abc import Iterator
from typing import BinaryIO, cast


@contextlib.contextmanager
def quiet_stderr() -> Iterator[None]:
    """File descriptor 2 leads nowhere inside; for short calls on the main thread (it is the whole process's)."""
    sys.stderr.flush()
    kept = os.dup(2)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)


class Forgiving(io.TextIOWrapper):
    """A stream whose other end may go at any time: what is said then is lost."""

    def write(self, text: str, /) -> int:
        """Say it, if anybody is there."""
        with contextlib.suppress(OSError):
            return super().write(text)
        return len(text)

    def flush(self) -> None:
        """Say what waits, if anybody is there."""
        with contextlib.suppress(OSError):
            super().flush()


def outlive_terminals() -> None:
    """Let this process speak on where its terminal is closed: a show without a supervisor outlives that, too."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        with contextlib.suppress(OSError, ValueError, AttributeError):
            raw = io.FileIO(stream.fileno(), "w", closefd=False)
            text = Forgiving(
                cast(BinaryIO, raw), encoding=stream.encoding, errors="backslashreplace", write_through=True
            )
            setattr(sys, name, text)
