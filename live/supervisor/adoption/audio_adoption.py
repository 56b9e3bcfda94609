"""Adoption of the audio process, which continues without its supervisor as long as an engine is connected.

Engine and supervisor share one end of its socket, so a restarted supervisor can reach it: it sends a new channel and a
new heartbeat, and the audio process answers with its process number.
"""

import contextlib
import json
import os
import select
import socket
import time
from typing import Final

from live.supervisor.adoption.adoption import AdoptedProcess
from live.supervisor.heartbeat import Heartbeat
from live.supervisor.line_channel import LineChannel
from live.supervisor.process import Child, ProcessManager
from live.supervisor.supervisor_link import SupervisorLink

ANSWERS_WITHIN: Final = 3.0
"""Seconds for the answer; the process checks five times a second."""


def adopt_audio(starter: ProcessManager, sound: socket.socket) -> Child | None:
    """Adopt the process at the other end of `sound`; None if there is no answer and another one is needed."""
    mine, theirs = socket.socketpair()
    heart = Heartbeat()
    try:
        socket.send_fds(sound, [b'{"adopt":true}'], [theirs.fileno(), heart.page.descriptor])
        theirs.close()
        mine.settimeout(ANSWERS_WITHIN)
        word, found, _, _ = socket.recv_fds(mine, 1 << 10, 1)
        child = Child.adopted("audio", LineChannel(mine), heart, AdoptedProcess(int(json.loads(word)["pid"]), found[0]))
    except (OSError, ValueError, KeyError, IndexError):
        theirs.close()
        mine.close()
        heart.close()
        return None
    starter.register(child.channel, lambda line: None, child.kill)
    return child


class AudioLink:
    """Supervisor link of the audio process, and its end of the engine's socket. Thread: its own."""

    def __init__(self, sock: socket.socket, link: SupervisorLink, *, round_s: float, largest: int) -> None:
        """`round_s`: most seconds that `receive_commands` waits; `largest`: most bytes of a command."""
        self._sock, self.link = sock, link
        self._round, self._largest = round_s, largest
        self.orphaned = False
        """Whether both supervisor and engine have gone."""

    def receive_commands(self) -> list[bytes]:
        """Return the commands of the engine that arrive within a round."""
        wire = [] if self.link.orphaned else [self.link.channel.socket]
        ready, _, _ = select.select([self._sock, *wire], [], [], self._round)
        if wire:
            self.link.receive()
        if self._sock not in ready:
            return []
        data, found = b"", list[int]()
        with contextlib.suppress(BlockingIOError):
            data, found, _, _ = socket.recv_fds(self._sock, self._largest, 2)
            if not data and not found:
                self.orphaned = self.link.orphaned
                time.sleep(0.0 if self.orphaned else self._round)
                return []
        if len(found) == 2:
            self._accept_supervisor(found)
            return []
        for descriptor in found:
            os.close(descriptor)
        return [data] if data else []

    def _accept_supervisor(self, found: list[int]) -> None:
        """Link to another supervisor."""
        self.link = SupervisorLink.of_descriptors(*found)
        process = os.pidfd_open(os.getpid())
        try:
            socket.send_fds(self.link.channel.socket, [json.dumps({"pid": os.getpid()}).encode()], [process])
        except OSError:  # it has given up waiting and started another process
            self.orphaned = True
        finally:
            os.close(process)
