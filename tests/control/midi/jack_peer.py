"""A program with one MIDI port on JACK: sends the lines of its input, and writes what it receives as lines, in hex."""

import gc
import sys
from collections import deque

import jack


def main(name: str, port: str, does: str) -> None:
    """Run until the input ends."""
    gc.disable()
    waiting: deque[bytes] = deque()
    jack.set_error_function(lambda message: None)
    jack.set_info_function(lambda message: None)
    client = jack.Client(name, no_start_server=True)
    own = client.midi_outports.register(port) if does == "sends" else client.midi_inports.register(port)

    def send(frames: int) -> None:
        own.clear_buffer()
        while waiting and own.max_event_size >= len(waiting[0]):
            own.write_midi_event(0, waiting.popleft())

    def receive(frames: int) -> None:
        for _, event in own.incoming_midi_events():
            sys.stdout.write(bytes(event).hex() + "\n")
        sys.stdout.flush()

    client.set_process_callback(send if does == "sends" else receive)
    client.activate()
    print("ready", flush=True)
    for line in sys.stdin:
        waiting.append(bytes.fromhex(line))


if __name__ == "__main__":
    main(*sys.argv[1:])
