"""The process that reads OSC for an engine; the supervisor starts it, and it goes on while engines change.

What is heard meanwhile waits in the socket between both, which the supervisor holds at either end.
"""

import os
import sys

from live.control.helper_process import HELLO, Told
from live.control.osc.osc_process import Reader
from live.supervisor.cpu_priority import ENGINE_NICE, come_forward
from live.supervisor.heartbeat import Phase
from live.supervisor.supervisor_link import Lifeline


def main() -> None:
    """Read until the supervisor has gone: an engine that outlives it starts such a process itself."""
    told = Told(int(sys.argv[1]), {"nice": 0})
    lifeline = Lifeline.inherited(int(sys.argv[3]), int(sys.argv[4]))
    come_forward(ENGINE_NICE)  # an operator is heard on a busy machine, too
    reader = Reader(told, int(sys.argv[2]))
    told.say(HELLO)
    lifeline.beat(0, Phase.RUNNING)
    while not (lifeline.alone or told.ended):
        reader.turn(lifeline.wire.socket)
        lifeline.listen()
        lifeline.beat(0, Phase.RUNNING)
    os._exit(0)  # the sockets are not ours to close


if __name__ == "__main__":
    main()
