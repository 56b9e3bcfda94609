"""The show: replay, journal, snapshots, score, reload, and what happens when something ends; who dances meanwhile."""

from pathlib import Path

from bench import _show_alive as alive
from bench import _show_desk as desk
from bench import _show_journal as journal
from bench import _show_reload as reload
from bench import _show_score as score
from bench import _show_screen as screen
from live.cli.bench import Row


def run(full: bool, shared: Path | None) -> list[Row]:
    """Figures against the bars of the show."""
    parts = (journal, desk, score, reload, alive, screen)
    return [row for part in parts for row in part.rows(full)]
