"""A program with one MIDI port on JACK: sends the lines of its input, or writes what it receives as lines; in hex.

All is done in JACK's real-time thread, which waits for no other: a server without a card overwrites what is late.
"""

import gc
import os
import select
import sys
from collections import deque

import jack


def main(name: str, port: str, does: str) -> None:
    """Run until it is killed, or its input ends."""
    gc.disable()
    os.set_blocking(0, False)
    waiting: deque[bytes] = deque()
    rest = b""
    jack.set_error_function(lambda message: None)
    jack.set_info_function(lambda message: None)
    client = jack.Client(name, no_start_server=True)
    own = client.midi_outports.register(port) if does == "sends" else client.midi_inports.register(port)

    def send(frames: int) -> None:
        nonlocal rest
        own.clear_buffer()
        try:
            *lines, rest = (rest + os.read(0, 65536)).split(b"\n")
        except BlockingIOError:
            lines = []
        waiting.extend(bytes.fromhex(line.decode()) for line in lines)
        while waiting and own.max_event_size >= len(waiting[0]):
            own.write_midi_event(0, waiting.popleft())

    def receive(frames: int) -> None:
        lines = [bytes(event).hex() for _, event in own.incoming_midi_events()]
        if lines:
            os.write(1, "".join(f"{line}\n" for line in lines).encode())

    client.set_process_callback(send if does == "sends" else receive)
    client.activate()
    os.write(1, b"ready\n")
    end = select.poll()
    end.register(0, 0)  # the end of the input, when the test is gone
    end.poll()
    os._exit(0)


if __name__ == "__main__":
    main(*sys.argv[1:])
