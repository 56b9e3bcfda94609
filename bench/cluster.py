"""Past one machine: render nodes in lockstep, and films in parts."""

from pathlib import Path

from bench._cluster_films import film_rows
from bench._cluster_nodes import rows
from live.cli.bench import Row


def run(full: bool, shared: Path | None) -> list[Row]:
    """Measure; with `full` more nodes, for longer, and longer films."""
    return [*rows(full), *film_rows(full)]
