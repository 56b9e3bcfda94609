"""Entry point of chaos runs: `live` with engines and disk that fail as configured in a folder.

Arguments: FOLDER, then the command line of `live`.
"""

import sys
from pathlib import Path

from live.app.processes import engine_main
from live.cli.main import main as run_live
from live.rehearse.chaos.injection import install_disk


def main() -> None:
    """Run `live` with the chaos run's engine command and disk faults."""
    folder = sys.argv.pop(1)
    install_disk(Path(folder))
    engine_main.ENGINE[:] = ["live.app.processes.chaos_engine_main", folder]
    run_live()


if __name__ == "__main__":
    main()
