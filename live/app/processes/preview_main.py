"""Process that simulates measures aside: it answers the questions of pages, at low priority, while the show goes on.

It reads the show's files for itself, so the show neither waits for it nor feeds it. A packet of the web server is a
question as JSON, [number, text], or [number] alone, which ends the present answer. Answers are packets ["text" or
"binary", number, part, parts, bytes], and ["end", number, text] as the last one.
"""

import contextlib
import json
import os
import select
import sys
import time
from pathlib import Path
from typing import Any, Final

from live.app.bridges import installed_bridges
from live.base.errors import PersonError
from live.base.fault_isolation import FAULTS
from live.control.helper_process import HelperChannel
from live.control.message_codec import encode_packet
from live.control.web.preview_client import PART_BYTES, refused_text
from live.document.preview_answers import PreviewAnswers, open_answers
from live.show.loader import load_show
from live.show.selection.show_clips import ShowTempo

TICKS_PER_LOOK: Final = 16
"""Simulated ticks between two looks for a new packet."""
MAX_LAST: Final = 20_000
"""Maximum length of the last text [characters]."""
PROGRESS_INTERVAL: Final = 0.5
"""Interval between two frames that tell how far it is [s]."""


class Interrupted(Exception):
    """The present question is not wanted any more."""


class PreviewMain:
    """Serves one question after the other."""

    def __init__(self, channel: HelperChannel) -> None:
        """`channel` has the show's files as its plan."""
        self._channel = channel
        self._answers: PreviewAnswers | None = None
        self._number, self._ticks, self._told = 0, 0, 0.0

    def run(self) -> None:
        """Answer until the other end is closed."""
        while not self._channel.closed:
            select.select([self._channel.socket], [], [])
            for packet in self._channel.packets():
                match packet:
                    case (int(number), str(text)):
                        self._serve(number, json.loads(text))  # a packet would make tuples of its lists
                    case _:
                        pass  # that answer has ended already

    def _serve(self, number: int, question: Any) -> None:
        self._number, self._told = number, time.monotonic()
        last: str | bytes = ""
        try:
            for frame in self._opened().answer(question):
                if last:
                    self._send(number, last)
                last = frame
        except Interrupted:
            last = ""
        except PersonError as error:  # the show's files are not valid now
            last = refused_text(question, error.message, error.remedy or "")
        except Exception as error:  # a fault of the program: the next question is answered
            FAULTS.record("the preview", error)
            last = refused_text(question, f"{type(error).__name__}: {error}"[:300], "")
        self._channel.socket.setblocking(True)  # the other end reads until it comes
        self._channel.socket.send(encode_packet(["end", number, last[:MAX_LAST]]))
        self._channel.socket.setblocking(False)

    def _opened(self) -> PreviewAnswers:
        if self._answers is None:
            plan = self._channel.plan
            recordings = None if plan["recordings"] is None else Path(plan["recordings"])
            tables = installed_bridges().patch_tables()
            path, tempo = Path(plan["patch"]), ShowTempo(**plan["tempo"])
            loaded = load_show(path, recordings=recordings, whole=False, tables=tables, tempo=tempo)
            self._answers = open_answers(loaded, seed=plan["seed"])
            self._answers.on_tick = self._look
        return self._answers

    def _look(self) -> None:
        self._ticks += 1
        if self._ticks % TICKS_PER_LOOK:
            return
        if select.select([self._channel.socket], [], [], 0.0)[0]:
            raise Interrupted
        now = time.monotonic()
        if self._answers is not None and now > self._told + PROGRESS_INTERVAL:
            self._told = now
            self._send(self._number, self._answers.progress())

    def _send(self, number: int, frame: str | bytes) -> None:
        data, kind = (frame.encode(), "text") if isinstance(frame, str) else (frame, "binary")
        parts = range(0, max(len(data), 1), PART_BYTES)
        for part, start in enumerate(parts):
            self._write([kind, number, part, len(parts), data[start : start + PART_BYTES]])

    def _write(self, packet: list[Any]) -> None:
        """Send a packet; wait while there is no room for it, unless the answer is not wanted any more."""
        data = encode_packet(packet)
        while True:
            with contextlib.suppress(BlockingIOError):
                self._channel.socket.send(data)
                return
            if select.select([self._channel.socket], [self._channel.socket], [])[0]:
                raise Interrupted


def main() -> None:
    """Answer until the web server has ended."""
    try:
        PreviewMain(HelperChannel(sys.argv[1])).run()
    except OSError:  # the other end is closed
        os._exit(0)


if __name__ == "__main__":
    main()
