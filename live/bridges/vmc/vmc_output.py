"""VMC output: sends the show's dancers as avatars to other programs, or a clip as a capture program would.

Run as a module, it is a helper process (`HelperProcess`), so sending costs the show's frames no time.
"""

import gc
import itertools
import select
import socket
import sys
import time
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.bridges.vmc.vmc_protocol import vmc_packets
from live.clock.time_source import SystemClock
from live.control.helper_process import HelperChannel
from live.motion.clip import Clip
from live.motion.forward_kinematics import local_rotations
from live.motion.skeleton import JOINT_COUNT

STATUS_INTERVAL: Final = 1.0
MOST_AVATARS: Final = 16
"""Maximum dancers of one target, each on its own port."""
ROW_LENGTH: Final = 3 + 4 * JOINT_COUNT
"""Values per dancer: hips [m], and the joints' world rotations."""


@dataclass(frozen=True, slots=True)
class AvatarTarget:
    """One target: the first dancer is sent to its port, the second to the next, and so on."""

    host: str
    port: int
    who: str = "1"
    """Dancer selection as in `live.show.group.casting`."""
    rate: float = 60.0
    """Maximum poses per second."""


class VmcOutput:
    """Sends dancers to one host. Thread: one."""

    def __init__(self, host: str, port: int) -> None:
        """Open the socket; OSError for an unknown host."""
        family, kind, protocol, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
        self._socket = socket.socket(family, kind, protocol)
        self._socket.setblocking(False)
        self._address: tuple[Any, ...] = address
        self.sent = self.failed = 0
        """Datagrams that the system accepted, and those that it refused."""

    def send_dancers(self, time: float, data: bytes) -> None:
        """Send dancers at `time` [s], from rows (n, ROW) of float32."""
        rows = np.frombuffer(data, np.float32).reshape(-1, ROW_LENGTH)[:MOST_AVATARS]
        local = local_rotations(rows[:, 3:].reshape(-1, JOINT_COUNT, 4))
        host, port, *more = self._address
        for number, (row, rotation) in enumerate(zip(rows, local, strict=True)):
            for datagram in vmc_packets(row[:3].astype(np.float64), rotation, time):
                self._send(datagram, (host, port + number, *more))

    def _send(self, datagram: bytes, address: Any) -> None:
        try:
            self._socket.sendto(datagram, address)
            self.sent += 1
        except (OSError, OverflowError):  # no receiver, no room, no such port
            self.failed += 1

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()


def pack_dancers(
    rows: npt.NDArray[np.integer], position: npt.NDArray[np.float32], rotation: npt.NDArray[np.float32]
) -> bytes:
    """Return the data for `VmcOutput.send_dancers`, of dancers `rows` (n,).

    `position` (A, J, 3) [m], `rotation` (A, J, 4).
    """
    told = np.empty((len(rows), ROW_LENGTH), np.float32)
    told[:, :3], told[:, 3:] = position[rows, 0], rotation[rows].reshape(len(rows), -1)
    return told.tobytes()


def main() -> None:
    """Send until the show ends."""
    told = HelperChannel(sys.argv[1])
    gc.disable()
    outs = [VmcOutput(host, port) for host, port in told.plan["targets"]]
    clock = SystemClock(told.plan["origin"])
    say_at = clock.now() + STATUS_INTERVAL
    while not told.closed:
        select.select([told.socket], [], [], STATUS_INTERVAL)
        newest = {packet[0]: packet for packet in told.packets()}  # after a delay only the latest packet of each target
        for index, moment, data in newest.values():
            outs[index].send_dancers(moment, data)
        if clock.now() >= say_at:
            say_at = clock.now() + STATUS_INTERVAL
            gc.collect(0)
            told.send_facts({"datagrams": sum(out.sent for out in outs), "failed": sum(out.failed for out in outs)})


def play_clip(
    clip: Clip, endpoint: tuple[str, int], *, first: int = 0, seconds: float | None = None, loop: bool = False
) -> int:
    """Send the clip's samples from `first` on, each when it is due; return how many were sent.

    `seconds`: maximum duration; `loop`: restart at the end. OSError for an unknown host.
    """
    family, kind, protocol, _, address = socket.getaddrinfo(*endpoint, type=socket.SOCK_DGRAM)[0]
    began = time.perf_counter()
    length = clip.sample_count - first
    last = length if not loop else None
    with socket.socket(family, kind, protocol) as sock:
        for number in itertools.count():
            due = number / clip.sample_rate
            if (last is not None and number >= last) or (seconds is not None and due >= seconds):
                return number
            wait = began + due - time.perf_counter()
            if wait > 0.0:
                time.sleep(wait)
            sample = first + number % length
            for data in vmc_packets(clip.root_position[sample], clip.rotation[sample], due):
                try:
                    sock.sendto(data, address)
                except ConnectionRefusedError:  # no receiver yet
                    continue
    return 0


if __name__ == "__main__":
    main()
