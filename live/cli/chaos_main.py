"""`live` with a supervisor whose engines and disk fail, as a chaos run's page says: FOLDER, then a command line."""

import sys
from pathlib import Path

from live.app.processes import engine_main
from live.cli.main import main as run_live
from live.rehearse.chaos.injection import install_disk


def main() -> None:
    """Run it; everything but the engines' command is as it always is."""
    folder = sys.argv.pop(1)
    install_disk(Path(folder))
    engine_main.ENGINE[:] = ["live.app.processes.chaos_engine_main", folder]
    run_live()


if __name__ == "__main__":
    main()
