"""Cluster: nodes and machines that share the work of one show."""

from pathlib import Path

from bench._cluster_films import film_rows
from live.cli.bench import Row


def run(full: bool, shared: Path | None) -> list[Row]:
    """Measure; with `full` longer films."""
    return film_rows(full)
