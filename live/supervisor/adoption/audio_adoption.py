"""The process that listens or plays, when its supervisor has died: it goes on as long as an engine is there to hear it.

Engine and supervisor have the same end of its socket, so that whoever begins anew can reach it: it is given a new wire
and a new heart, and says who it is.
"""

import contextlib
import json
import os
import select
import socket
import time
from typing import Final

from live.supervisor.adoption.adoption import Adopted
from live.supervisor.heartbeat import Heartbeat
from live.supervisor.line_channel import Wire
from live.supervisor.process import Child, Starter
from live.supervisor.supervisor_link import Lifeline

ANSWERS_WITHIN: Final = 3.0
"""Seconds; it looks five times a second."""


def adopt_sound(starter: Starter, sound: socket.socket) -> Child | None:
    """The process that is at the other end of `sound`; None if nobody answers there: then another one is to begin."""
    mine, theirs = socket.socketpair()
    heart = Heartbeat()
    try:
        socket.send_fds(sound, [b'{"adopt":true}'], [theirs.fileno(), heart.descriptor])
        theirs.close()
        mine.settimeout(ANSWERS_WITHIN)
        word, found, _, _ = socket.recv_fds(mine, 1 << 10, 1)
        child = Child.adopted("audio", Wire(mine), heart, Adopted(int(json.loads(word)["pid"]), found[0]))
    except (OSError, ValueError, KeyError, IndexError):
        theirs.close()
        mine.close()
        heart.close()
        return None
    starter.listen(child.wire, lambda line: None, child.kill)
    return child


class SoundLifeline:
    """The lifeline of that process, and its end of the socket. Thread: its own."""

    def __init__(self, sock: socket.socket, lifeline: Lifeline, *, round_s: float, largest: int) -> None:
        """`round_s`: seconds that `orders` waits at most; `largest`: bytes of an order."""
        self._sock, self.lifeline = sock, lifeline
        self._round, self._largest = round_s, largest
        self.deserted = False
        """Whether neither supervisor nor engine is there any more."""

    def orders(self) -> list[bytes]:
        """What an engine has ordered, within a round."""
        wire = [] if self.lifeline.alone else [self.lifeline.wire.socket]
        ready, _, _ = select.select([self._sock, *wire], [], [], self._round)
        if wire:
            self.lifeline.listen()
        if self._sock not in ready:
            return []
        data, found = b"", list[int]()
        with contextlib.suppress(BlockingIOError):
            data, found, _, _ = socket.recv_fds(self._sock, self._largest, 2)
            if not data and not found:
                self.deserted = self.lifeline.alone
                time.sleep(0.0 if self.deserted else self._round)
                return []
        if len(found) == 2:
            self._take(found)
            return []
        for descriptor in found:
            os.close(descriptor)
        return [data] if data else []

    def _take(self, found: list[int]) -> None:
        """Another supervisor is there."""
        self.lifeline = Lifeline.inherited(*found)
        process = os.pidfd_open(os.getpid())
        try:
            socket.send_fds(self.lifeline.wire.socket, [json.dumps({"pid": os.getpid()}).encode()], [process])
        except OSError:  # it waited no longer: another process plays
            self.deserted = True
        finally:
            os.close(process)
