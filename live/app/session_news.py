"""What the parts of a running show have to tell: what was refused, what is wrong, what has joined."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from rich.console import Console

from live.app.news import News
from live.app.services.operators_port import OperatorsPort
from live.base.fault_isolation import FAULTS
from live.show.core import Show
from live.show.patch.hot_reload import PatchWatch
from live.show.selection.library_watch import LibraryWatch

if TYPE_CHECKING:
    from live.app.services.midi_part import OnMidi
    from live.app.session_sound import AudioSource


def session_news(
    show: Show,
    osc: OperatorsPort,
    listens: "AudioSource | None",
    midi: "OnMidi | None",
    watch: PatchWatch,
    library: LibraryWatch | None,
    *,
    journal: Callable[[], str] = lambda: "",
    more: Sequence[Callable[[], str]] = (),
) -> News:
    """Tells on the terminal what is refused and what joins: with `--headless` there is no overlay that does.

    `listens`: a device that is listened to, if there is one; `more`: last refusals of others.
    """
    console = Console(stderr=True, highlight=False)
    refusals: list[Callable[[], str]] = [osc.refusal, lambda: show.refusals.words, *more]
    before = FAULTS.news()  # of another show in this process, if there was one

    def faults() -> str:
        news = FAULTS.news()
        return news if news != before else ""

    others: list[Callable[[], str]] = [journal, faults]
    if listens is not None:
        others.append(lambda: _audio_problem(listens))
    if midi is not None:
        refusals.append(midi.refusal)
        others += [midi.problem, midi.note, midi.said]
    refusals.append(lambda: watch.problem)
    others.append(lambda: watch.told)
    if library is not None:
        refusals.append(lambda: library.problem)
        others.append(lambda: library.joined)

    def say(line: str) -> None:
        console.print(line, style="yellow", soft_wrap=True, markup=False)

    return News(refusals, others, say)


def _audio_problem(listens: "AudioSource") -> str:
    problem = str(listens.facts()["problem"])
    return f"sound: {problem}" if problem else ""
