"""OSC reader process for an engine; the supervisor starts it, and it keeps running while engines change.

Messages meanwhile wait in the socket to the engine, of which the supervisor holds both ends.
"""

import os
import sys

from live.control.helper_process import HELLO, Told
from live.control.osc.osc_process import Reader
from live.supervisor.cpu_priority import ENGINE_NICE, come_forward
from live.supervisor.heartbeat import Phase
from live.supervisor.supervisor_link import Lifeline


def main() -> None:
    """Read until the supervisor has ended; an engine that outlives it starts its own reader."""
    told = Told(int(sys.argv[1]), {"nice": 0})
    lifeline = Lifeline.inherited(int(sys.argv[3]), int(sys.argv[4]))
    come_forward(ENGINE_NICE)  # operators must be heard on a busy machine too
    reader = Reader(told, int(sys.argv[2]))
    told.say(HELLO)
    lifeline.beat(0, Phase.RUNNING)
    while not (lifeline.alone or told.ended):
        reader.turn(lifeline.wire.socket)
        lifeline.listen()
        lifeline.beat(0, Phase.RUNNING)
    os._exit(0)  # skip clean-up: the sockets are inherited, others use them


if __name__ == "__main__":
    main()
