"""Another program with Ableton Link, kept minimal: commands on stdin, answers on stdout, a JSON line each.

Run in a private network only. It is independent of this project; its clock conversion is its own.
"""

import json
import sys
import time

import link


def micros_of(clock: link.Clock, at: float) -> int:
    """Link's microseconds at `at` [s of perf_counter], from the narrowest of several readings of both clocks."""
    looks = []
    for _ in range(20):
        before = time.perf_counter()
        micros = clock.micros()
        after = time.perf_counter()
        looks.append((after - before, micros - (before + after) * 5e5))
    return round(at * 1e6 + min(looks)[1])


def main() -> None:
    participant = link.Link(120.0)
    clock = participant.clock()
    print(json.dumps({"ready": True}), flush=True)
    for line in sys.stdin:
        command = json.loads(line)
        state = participant.captureSessionState()
        match command["do"]:
            case "new":
                participant.enabled = False
                participant = link.Link(command["bpm"])
                clock = participant.clock()
            case "enable":
                participant.enabled = command["on"]
            case "share":
                participant.startStopSyncEnabled = command["on"]
            case "tempo":
                state.setTempo(command["bpm"], clock.micros())
                participant.commitSessionState(state)
            case "play":
                state.setIsPlaying(command["on"], clock.micros())
                participant.commitSessionState(state)
            case "force":
                state.forceBeatAtTime(command["beat"], clock.micros(), 4.0)
                participant.commitSessionState(state)
        quantum = command.get("quantum", 4.0)
        micros = micros_of(clock, command.get("at", time.perf_counter()))
        state = participant.captureSessionState()
        answer = {
            "peers": participant.numPeers(),
            "tempo": state.tempo(),
            "phase": state.phaseAtTime(micros, quantum),
            "playing": state.isPlaying(),
        }
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
