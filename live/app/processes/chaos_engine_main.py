"""Engine process with fault injection for a chaos run; otherwise as `engine_main`."""

import sys
from pathlib import Path

from live.app.processes import engine_main


def main() -> None:
    """Arguments: the run's `FOLDER`, then those of every engine."""
    from live.rehearse.chaos.injection import install_in_engine

    install_in_engine(Path(sys.argv.pop(1)))
    engine_main.main()


if __name__ == "__main__":
    main()
