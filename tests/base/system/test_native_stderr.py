"""Standard streams of a process that outlives its terminal."""

import os
import pty
import subprocess
import sys

from tests.control.waiting import wait_for

SAYS = """
import sys, time
from pathlib import Path
from live.base.system.native_stderr import survive_terminal_close
survive_terminal_close()
print("begun", flush=True)
while not Path(sys.argv[1]).exists():
    time.sleep(0.01)
for number in range(100):
    print("to nobody", number, file=sys.stderr, flush=True)
    print("nor here", flush=True)
Path(sys.argv[2]).touch()
"""


def test_process_survives_output_to_closed_terminal(tmp_path):
    mine, theirs = pty.openpty()
    closed, done = tmp_path / "closed", tmp_path / "done"
    process = subprocess.Popen(
        [sys.executable, "-c", SAYS, str(closed), str(done)],
        stdin=subprocess.DEVNULL, stdout=theirs, stderr=theirs, start_new_session=True,
    )  # fmt: skip
    os.close(theirs)
    assert os.read(mine, 100).startswith(b"begun")
    os.close(mine)
    closed.touch()
    assert wait_for(lambda: process.poll() is not None, 20)
    assert process.returncode == 0
    assert done.exists()
