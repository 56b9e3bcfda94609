"""An engine in which faults are raised, as a chaos run's page says; else that of every show (`engine_main`)."""

import sys
from pathlib import Path

from live.app.processes import engine_main


def main() -> None:
    """`FOLDER` of the run, then what every engine is told."""
    from live.rehearse.chaos.injection import install_in_engine

    install_in_engine(Path(sys.argv.pop(1)))
    engine_main.main()


if __name__ == "__main__":
    main()
