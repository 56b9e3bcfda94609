"""Suppression of stderr output by C libraries (ALSA, JACK and Mesa on a machine without hardware), and standard streams
that survive the closing of their terminal.
"""

import contextlib
import io
import os
import sys
from collections.abc import Iterator
from typing import BinaryIO, cast


@contextlib.contextmanager
def suppress_native_stderr() -> Iterator[None]:
    """Redirect file descriptor 2 to the null device; for short calls on the main thread (it affects the whole
    process)."""
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


class FaultTolerantStream(io.TextIOWrapper):
    """A stream that ignores write errors: after its terminal has closed, output is lost."""

    def write(self, text: str, /) -> int:
        """Write the text; ignore OSError."""
        with contextlib.suppress(OSError):
            return super().write(text)
        return len(text)

    def flush(self) -> None:
        """Flush; ignore OSError."""
        with contextlib.suppress(OSError):
            super().flush()


def survive_terminal_close() -> None:
    """Let this process run on after its terminal is closed, as a show without a supervisor does."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        with contextlib.suppress(OSError, ValueError, AttributeError):
            raw = io.FileIO(stream.fileno(), "w", closefd=False)
            text = FaultTolerantStream(
                cast(BinaryIO, raw), encoding=stream.encoding, errors="backslashreplace", write_through=True
            )
            setattr(sys, name, text)
