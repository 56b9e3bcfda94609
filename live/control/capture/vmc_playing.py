"""A clip sent by the VMC protocol in real time, as a capture program would send somebody who dances it."""

import itertools
import socket
import time

from live.control.capture.vmc_encode import vmc_packets
from live.motion.clip import Clip


def play_clip(
    clip: Clip, endpoint: tuple[str, int], *, first: int = 0, seconds: float | None = None, loop: bool = False
) -> int:
    """Send the clip's samples from `first` on, each when it is due; returns how many were sent.

    `seconds`: end after so long; `loop`: begin again at the end. OSError for a host that is not known.
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
                except ConnectionRefusedError:  # nobody listens yet
                    continue
    return 0
