"""Scheduler priorities of show processes, each in a session of its own."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

GROUPS = Path("/proc/self/autogroup")

STEPS = """
from live.supervisor.cpu_priority import BACKGROUND_NICE, restore_priority, raise_priority, lower_priority
import ctypes, os, sys
if sys.argv[1:]:
    os.setresuid(65534, 65534, 65534)
    ctypes.CDLL(None).prctl(4, 1)  # PR_SET_DUMPABLE: its files in /proc are its own again
def weight():
    return int(open("/proc/self/autogroup").read().split()[-1])
processors = lower_priority()
assert weight() == BACKGROUND_NICE, weight()
raise_priority(0, processors)
assert weight() == 0, weight()
lower_priority()
restore_priority(os.getpid())
assert weight() == 0, weight()
raise_priority(-5)
assert weight() in (0, -5), weight()
"""


@pytest.mark.skipif(not GROUPS.exists(), reason="this system does not weigh sessions (sched_autogroup)")
@pytest.mark.parametrize("rights", [True, False])
def test_preparing_process_has_low_weight_and_dancing_process_has_normal_weight(rights):
    """The current user and (where that is root) a user limited by the system to ten changes a second."""
    if not rights and os.geteuid():
        pytest.skip("only root can become another user")
    command = [sys.executable, "-c", STEPS, *([] if rights else ["other"])]
    done = subprocess.run(command, start_new_session=True, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
