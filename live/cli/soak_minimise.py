"""`live soak --minimise JOURNAL`: a journal that fails becomes a short one that fails in the same way."""

from pathlib import Path
from typing import Any

from rich.console import Console

from live.base.errors import PersonError

SHORT = ".min.jsonl"
"""What the name of the short journal ends with."""


def minimise_journal(path: Path, to: Path | None, seconds: float, console: Console) -> dict[str, Any]:
    """Make it short, write it to `to` (beside it without one), and say what is left, as the report's facts."""
    from live.rehearse.journal_minimiser import minimise
    from live.show.journal.journal_reading import JournalError
    from live.show.journal.replay_start import ReplayError

    def tell(words: str) -> None:
        console.print(words, style="dim", soft_wrap=True, markup=False)

    try:
        found = minimise(path, seconds=seconds, tell=tell)
    except (JournalError, ReplayError) as error:
        raise PersonError(str(error)) from None
    if found is None:
        return {"ok": True, "fails": False, "summary": [f"{path} does not fail: nothing to minimise"]}
    to = to or path.with_name(path.name.removesuffix(".jsonl") + SHORT)
    try:
        found.write(to)
    except OSError as error:
        raise PersonError(f"cannot write {to}: {error.strerror}") from None
    events, ticks = found.before
    words = f"{events} events in {ticks / 64.0:.1f} s became {len(found.entries)} in {found.end / 64.0:.1f} s: {to}"
    return {
        "ok": False, "fails": True, "journal": str(to), "failure": found.failure.facts(), "tried": found.tried,
        "events": [events, len(found.entries)], "ticks": [ticks, found.end], "summary": [str(found.failure), words],
    }  # fmt: skip
