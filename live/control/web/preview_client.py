"""Client of the preview process: passes the questions of pages on, one after the other, and their answers back.

The process is started at the first question, and ended when nobody has asked for a while. It belongs to the web server:
the show neither starts it nor waits for it.
"""

import asyncio
import contextlib
import json
import subprocess
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import Any, Final

from live.base.fault_isolation import FAULTS
from live.base.system.channel import Packets, receive_packet
from live.control.helper_process import spawn_helper
from live.control.message_codec import PacketError, decode_packet, encode_packet

PART_BYTES: Final = 32_768
"""Maximum length of a part of an answer."""
MAX_QUESTION_BYTES: Final = 60_000
MAX_ANSWER_BYTES: Final = 64_000_000
NICE: Final = 15
"""How much lower its priority is than the show's."""
IDLE_S: Final = 180.0
"""The process is ended when nobody has asked for so long [s]."""
SILENCE_S: Final = 60.0
"""A process that tells nothing for so long [s] while it should answer is replaced."""
Deliver = Callable[[str | bytes], None]


def refused_text(question: Any, what: str, remedy: str) -> str:
    """Return the frame that refuses a question."""
    name = question.get("id") if isinstance(question, dict) else None
    name = name if isinstance(name, str | int) else None
    return json.dumps({"kind": "refused", "id": name, "refused": [{"what": what, "remedy": remedy}]})


@dataclass(slots=True, eq=False)
class _Asked:
    page: Hashable
    question: dict[str, Any]
    text: str
    """The question as JSON."""
    deliver: Deliver
    wanted: bool = True


class _Lost(Exception):
    """The process has ended, or tells nothing any more."""


class PreviewClient:
    """All questions of one show's pages. Thread: the loop's."""

    def __init__(self, module: str, plan: dict[str, Any], *, idle: float = IDLE_S, silence: float = SILENCE_S) -> None:
        """`module` is run as the process, with `plan` as its first packet; `idle`, `silence` [s]: see above."""
        self.module = module
        """The module of the process; empty if there is none."""
        self._plan = plan | {"nice": NICE}
        self._idle, self._silence = idle, silence
        self._waiting: dict[Hashable, _Asked] = {}  # the latest question of each page, the oldest first
        self._present: _Asked | None = None
        self._wake = asyncio.Event()
        self._socket: Packets | None = None
        self._process: subprocess.Popen[bytes] | None = None
        self._number = 0
        self.answered = 0
        """Number of questions that were answered."""
        self.starts = 0
        """Number of processes that were started."""

    @property
    def pid(self) -> int | None:
        """The id of the process; None while there is none."""
        return None if self._process is None else self._process.pid

    def ask(self, page: Hashable, question: dict[str, Any], deliver: Deliver) -> None:
        """Ask for a page. Its former question, if it is not answered yet, ends with a frame `replaced`.

        `deliver` gets the frames of the answer; the last one is of the kind `done`, `refused` or `replaced`.
        """
        try:
            text = json.dumps(question)
        except RecursionError:
            deliver(refused_text(question, "its brackets are nested too deep", ""))
            return
        if len(text) > MAX_QUESTION_BYTES:
            deliver(refused_text(question, "the question is too long", f"at most {MAX_QUESTION_BYTES} bytes"))
            return
        former = self._waiting.get(page)
        if former is None and self._present is not None and self._present.page == page and self._present.wanted:
            former = self._present
            self._interrupt(former)
        if former is not None:
            former.deliver(json.dumps({"kind": "replaced", "id": former.question.get("id")}))
        self._waiting[page] = _Asked(page, question, text, deliver)  # in the turn of the former one
        self._wake.set()

    def forget(self, page: Hashable) -> None:
        """Drop the question of a page that has left."""
        self._waiting.pop(page, None)
        if self._present is not None and self._present.page == page:
            self._interrupt(self._present)

    def _interrupt(self, asked: _Asked) -> None:
        asked.wanted = False
        if self._socket is not None:
            with contextlib.suppress(OSError):  # full: then it reads soon; gone: that is noticed soon
                self._socket.send(encode_packet([self._number]))

    async def run(self) -> None:
        """Serve the questions."""
        try:
            while True:
                try:
                    await asyncio.wait_for(self._wake.wait(), self._idle)
                except TimeoutError:
                    self.close()
                    continue
                self._wake.clear()
                while self._waiting:
                    self._present = self._waiting.pop(next(iter(self._waiting)))
                    try:
                        await self._serve(self._present)
                    finally:
                        self._present = None
        finally:
            self.close()

    async def _serve(self, asked: _Asked) -> None:
        try:
            await self._answer(asked)
            return
        except _Lost as error:
            words = str(error)
        except (OSError, PacketError) as error:
            words = f"the preview cannot be reached: {error}"
        except Exception as error:
            FAULTS.record("the preview's client", error)
            words = f"the preview failed: {type(error).__name__}"
        self.close()
        if asked.wanted:
            asked.deliver(refused_text(asked.question, words, "ask again: another one is started"))

    async def _answer(self, asked: _Asked) -> None:
        """Pass a question on, and its answer back; _Lost if the process ends."""
        channel = self._started()
        self._number += 1
        channel.send(encode_packet([self._number, asked.text]))
        parts, size = list[bytes](), 0
        while True:
            try:
                data = await asyncio.wait_for(receive_packet(channel), self._silence)
            except TimeoutError:
                raise _Lost("the preview does not answer any more and was ended") from None
            if not data:
                raise _Lost("the preview ended unexpectedly")
            match decode_packet(data):
                case ("end", self._number, str(last)):
                    self._present = None  # a new question of this page does not replace it any more
                    if asked.wanted and last:
                        self.answered += 1
                        asked.deliver(last)
                    return
                case (("text" | "binary") as kind, self._number, int(part), int(count), bytes(piece)):
                    size += len(piece)
                    if part != len(parts) or size > MAX_ANSWER_BYTES:
                        raise _Lost("the preview's answer is damaged")
                    parts.append(piece)
                    if len(parts) == count:
                        frame = b"".join(parts)
                        parts.clear()
                        if asked.wanted:
                            asked.deliver(frame.decode() if kind == "text" else frame)
                case _:
                    raise _Lost("the preview's answer is damaged")

    def _started(self) -> Packets:
        """Return the channel of a process that runs."""
        if self._process is not None and self._process.poll() is not None:
            self.close()
        if self._socket is None:
            self._socket, self._process = spawn_helper(self.module)
            self.starts += 1
            self._socket.send(encode_packet(self._plan))
        return self._socket

    def close(self) -> None:
        """End the process. It has nothing to save."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.wait()
