"""A supervisor of test engines as a process that can be killed: `python -m tests.supervisor.made_show JOURNAL PLAN`.

Adopts the orphaned engine of an earlier supervisor. Messages go to stdout.
"""

import json
import sys
from pathlib import Path

from live.app.exit_codes import install_signal_handlers
from live.supervisor.adoption.adoption import find_engine
from live.supervisor.adoption.journal_resume import read_interrupted
from live.supervisor.supervisor import Supervisor
from live.supervisor.supervisor_config import SupervisorConfig

LABEL = "made"


def main() -> None:
    install_signal_handlers()
    path, plan = Path(sys.argv[1]), sys.argv[2]
    found = find_engine(LABEL)
    left = read_interrupted(path) if found is None else None
    print("adopted" if found else "resumed" if left else "begun", flush=True)
    orders = SupervisorConfig(
        engine=[sys.executable, "-m", "tests.supervisor.made_engine"],
        show=plan if found is None else found.show,
        journal=path,
        label=LABEL,
        spare_after=0.1,
        spare=json.loads(plan).get("spare", True),
    )
    sys.exit(Supervisor(orders, lambda line: print(line, flush=True), found, left).run())


if __name__ == "__main__":
    main()
