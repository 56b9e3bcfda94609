"""Edits of a show that runs elsewhere: sent by OSC, answers read back."""

import json
import socket
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Final

from live.base.errors import PersonError
from live.control.events.document import MAX_EDIT_LENGTH
from live.control.osc.osc_codec import OscRejected, decode, encode
from live.document.edit import Edit

ANSWERS: Final = "/dance/status/document_answers"
LOG: Final = "/dance/status/document_log"
TIMEOUT: Final = 10.0
"""Longest wait for an answer [s]."""
ASK_INTERVAL: Final = 0.03
"""Interval between two questions for it [s]."""


class RemoteDocument:
    """The document of the show that receives OSC at an address."""

    def __init__(self, host: str, port: int, by: str, *, timeout: float = TIMEOUT) -> None:
        """`by`: who edits. PersonError if there is no such host."""
        self._where, self._by, self._timeout = f"{host}:{port}", by, timeout
        try:
            family, kind, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
            self._socket = socket.socket(family, kind)
            self._socket.connect(address)
        except OSError as error:
            raise PersonError(
                f"--to {self._where}: {error}", "HOST:PORT of the show's OSC, as in 127.0.0.1:9010"
            ) from None
        self._socket.settimeout(ASK_INTERVAL)

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()

    def edit(self, edits: Sequence[Edit]) -> list[dict[str, Any]]:
        """Send edits one after the other and return their answers; PersonError if the show does not answer."""
        found = []
        for number, edit in enumerate(edits, start=1):
            name = f"{self._by or 'live'} {time.monotonic_ns()} {number}"
            text = json.dumps(replace(edit, id=name, by=edit.by or self._by).to_json_values())
            if len(text) > MAX_EDIT_LENGTH:
                raise PersonError(f"edit {number}: {len(text)} characters; by OSC at most {MAX_EDIT_LENGTH}")
            answer = self._ask("/dance/document/edit", (text,), lambda one, name=name: one.get("id") == name)  # type: ignore[misc]
            found.append({**answer, "id": edit.id})
        return found

    def command(self, what: str, *values: Any, timeout: float = TIMEOUT) -> dict[str, Any]:
        """Send `undo`, `redo`, `restore`, `music` or `keep/…` and return its answer; wait `timeout` [s] for it."""
        word = what.partition("/")[0]
        address, sent = f"/dance/document/{what}", (*values, self._by)
        return self._ask(address, sent, lambda one: one.get("what") == word, timeout)

    def log(self) -> list[dict[str, Any]]:
        """Return the latest revisions."""
        return self._read(LOG)

    def _ask(
        self,
        address: str,
        values: tuple[Any, ...],
        fits: Callable[[dict[str, Any]], bool],
        timeout: float | None = None,
    ) -> dict[str, Any]:
        """Send a command and return the first answer that was not there before and that `fits`."""
        before = self._read(ANSWERS)
        self._send(address, values)
        end = time.monotonic() + (timeout or self._timeout)
        while time.monotonic() < end:
            answers = self._read(ANSWERS)
            new = answers[len(before) :] if answers[: len(before)] == before else answers
            for answer in new:
                if fits(answer) and answer not in before:
                    return {
                        key: answer[key]
                        for key in ("id", "revision", "inverse", "waits", "refused", "notes", "note_count")
                        if key in answer
                    }
        raise PersonError(f"the show at {self._where} did not answer the edit", "is this its operators' OSC port?")

    def _read(self, address: str) -> list[dict[str, Any]]:
        """Return a published list; empty if the show has published none yet."""
        end = time.monotonic() + self._timeout
        while time.monotonic() < end:
            self._send("/dance/get", (address,))
            try:
                packet = self._socket.recv(65536)
            except TimeoutError:
                continue
            except OSError:
                time.sleep(ASK_INTERVAL)
                continue
            for message in _messages(packet):
                if message.address == address:
                    return list(json.loads(str(message.arguments[0])))
                if message.address == "/dance/no_value":
                    return []
        raise PersonError(f"no show answers at {self._where}", "start it, or name its OSC address: --to HOST:PORT")

    def _send(self, address: str, values: tuple[Any, ...]) -> None:
        try:
            self._socket.send(encode(address, values))
        except OSError:
            time.sleep(ASK_INTERVAL)  # nobody listens yet


def _messages(packet: bytes) -> list[Any]:
    try:
        return list(decode(packet))
    except OscRejected:
        return []
