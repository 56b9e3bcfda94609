"""OSC reader process for an engine; the supervisor starts it, and it keeps running while engines change.

Messages meanwhile wait in the socket to the engine, of which the supervisor holds both ends.
"""

import os
import sys

from live.control.helper_process import HELLO, HelperChannel
from live.control.osc.osc_process import OscReader
from live.supervisor.cpu_priority import ENGINE_NICE, raise_priority
from live.supervisor.heartbeat import Phase
from live.supervisor.supervisor_link import SupervisorLink


def main() -> None:
    """Read until the supervisor has ended; an engine that outlives it starts its own reader."""
    told = HelperChannel(sys.argv[1], {"nice": 0})
    lifeline = SupervisorLink.of_arguments(*sys.argv[3:5])
    raise_priority(ENGINE_NICE)  # operators must be heard on a busy machine too
    reader = OscReader(told, int(sys.argv[2]))
    told.send_facts(HELLO)
    lifeline.beat(0, Phase.RUNNING)
    while not (lifeline.orphaned or told.closed):
        reader.process_once(lifeline.channel.socket)
        lifeline.receive()
        lifeline.beat(0, Phase.RUNNING)
    os._exit(0)  # skip clean-up: the sockets are inherited, others use them


if __name__ == "__main__":
    main()
