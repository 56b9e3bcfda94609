"""Cluster: nodes and machines that share the work of one show."""

from pathlib import Path

from bench import _cluster_nodes
from live.cli.bench import Row


def run(full: bool, shared: Path | None) -> list[Row]:
    """Measure; with `full` more nodes and for longer."""
    return _cluster_nodes.rows(full)
