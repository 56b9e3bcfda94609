"""Updates of the examples of partners while a show runs: edited files of pairs, and the swap at a measure line (H026).

A watch reads a file of pairs that was edited, learns from it beside the show, and offers the new bank; an event in the
journal names it and holds the files' texts. The show takes over the bank at the next measure line.
"""

import json
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, Final

from live.base.compression import compress_text, decompress_text
from live.base.errors import PersonError
from live.base.fault_isolation import FAULTS
from live.control.events.events import ControlEvent, ExamplesChanged
from live.graph.step_library import StepLibrary
from live.library.partner_pairs import pairs_text
from live.show.background_work import short_switch_interval
from live.show.desk.refusals import Refusals
from live.show.partner.example_bank import ExampleBank
from live.show.partner.partner_sources import check_reactions, load_example_bank, pairs_path
from live.show.patch.patch import Patch
from live.show.state.constants import walk_ahead

MAX_EVENT_CHARACTERS: Final = 4_000_000
"""Most characters of files of pairs in one event: larger changes wait for the next start."""
MAX_LISTED: Final = 8


class ExampleUpdates:
    """Holds new examples from the watch's thread until the measure line from which on they are danced."""

    def __init__(self, reserve: Mapping[str, ExampleBank] | None, refusals: Refusals) -> None:
        """`reserve`: the banks that events of a replay name, which has no watch, by their digests."""
        self._reserve = dict(reserve or {})
        self._refusals = refusals
        self._offered: dict[str, ExampleBank] = {}
        self._next: ExampleBank | None = None

    @property
    def at_rest(self) -> bool:
        """Whether no bank waits for the measure line."""
        return self._next is None

    def set_reserve(self, reserve: Mapping[str, ExampleBank]) -> None:
        """Set the banks that events of a replay name."""
        self._reserve = dict(reserve)

    def offer(self, bank: ExampleBank) -> None:
        """Store a bank for the event that names its digest. Thread: any."""
        self._offered[bank.digest()] = bank

    def handle(self, event: ExamplesChanged) -> None:
        """Have the bank that the event names wait for the next measure line."""
        bank = self._offered.pop(event.bank, None) or self._reserve.get(event.bank)
        if bank is None:
            self._refusals.add(f"{event.source}: nobody has learnt from the new examples")
            return
        self._next = bank

    def drop(self) -> None:
        """Drop the waiting bank."""
        self._next = None

    def pop(self) -> ExampleBank | None:
        """Return and clear the waiting bank, None if there is none."""
        bank, self._next = self._next, None
        return bank


def texts_of(packed: str) -> dict[str, str]:
    """Return the files of pairs in an event, by their names in the patch; ValueError if it is damaged."""
    found = json.loads(decompress_text(packed))
    if not isinstance(found, dict) or not all(isinstance(text, str) for text in found.values()):
        raise ValueError("texts by name expected")
    return found


def former_texts(changes: Iterable[ExamplesChanged]) -> dict[str, str]:
    """Return what files of pairs held before all `changes`, by their names in the patch; ValueError for damage."""
    found: dict[str, str] = {}
    for event in changes:
        found = texts_of(event.was) | found
    return found


def later_banks(
    changes: Iterable[ExamplesChanged], first: ExampleBank, patch: Patch, path: Path, library: StepLibrary
) -> dict[str, ExampleBank]:
    """Return the banks that `changes` name, by their digests, for a show that begins with `first`. Slow: it learns.

    Raises PersonError for recordings that have changed since, ValueError for damaged events.
    """
    bank, found = first, {}
    for event in changes:
        made = load_example_bank(patch, path, library, texts=bank.texts | texts_of(event.now), former=bank)
        if made is None or made.digest() != event.bank:
            raise PersonError("the recordings of [[partner]] have changed since", "the same files")
        bank = found[event.bank] = made
    return found


class ExamplesWatch:
    """Watches the files of pairs of one show. `poll` learns from an edited file; the show then takes over from it.

    Recordings have to be there before the pair that names them is written.
    """

    def __init__(
        self,
        path: Path,
        library: StepLibrary,
        bank: ExampleBank,
        *,
        offer: Callable[[ExampleBank], None],
        post: Callable[[ControlEvent], None],
        now: Callable[[], float],
    ) -> None:
        """`path` of the patch; `offer` passes on a bank, `post` the event that has it taken over, at the time `now()`.

        `bank` is the one with which the show began, or goes on.
        """
        self._path, self._library, self._bank = path, library, bank
        self._offer, self._post, self._now = offer, post, now
        self._last_stamp = self._handled_stamp = self._stamp()
        self.problem = ""
        """Why the last edit was refused, empty if it was not."""
        self.last_change = ""
        """Description of the last change, empty before the first."""

    def _stamp(self) -> tuple[tuple[str, int, int], ...]:
        """Return names, times and sizes of the files, to detect edits; () while one is not there."""
        rows = []
        try:
            for name in self._bank.texts:
                facts = pairs_path(name, self._path).stat()
                rows.append((name, facts.st_mtime_ns, facts.st_size))
        except (OSError, PersonError):  # it is being moved: poll again later
            return ()
        return tuple(rows)

    def poll(self, patch: Patch) -> bool:
        """Poll once, for a show of this `patch`; return whether new examples were offered. Slow if a file has changed.

        While it learns nothing else is read; what was written meanwhile is read by the next poll.
        """
        stamp = self._stamp()
        settled, self._last_stamp = stamp == self._last_stamp, stamp
        if not settled or stamp == self._handled_stamp or not stamp:
            return False
        self._handled_stamp = stamp
        try:
            with short_switch_interval():
                return self._update(patch)
        except (PersonError, ValueError, OSError) as error:
            self.problem = f"new examples: {error}; the present ones stay"
            return False
        except Exception as error:  # a bug: keep watching, and report it
            FAULTS.record("the reader of new examples", error)
            self.problem = f"new examples: they cannot be read ({type(error).__name__}: {error})"
            return False

    def _update(self, patch: Patch) -> bool:
        texts = {name: pairs_text(pairs_path(name, self._path)) for name in self._bank.texts}
        edited = sorted(name for name, text in texts.items() if text != self._bank.texts[name])
        if not edited:
            self.problem = ""
            return False
        bank = load_example_bank(patch, self._path, self._library, texts=texts, former=self._bank)
        assert bank is not None  # there are files, so there are partners
        check_reactions(patch, bank)
        for section, new, old in zip(patch.partner, bank.example_sets, self._bank.example_sets, strict=True):
            if not new.fits(old):
                raise PersonError(
                    f"partner {section.name!r}: the new examples have other units", "restart the show to use them"
                )
        was, now = (_packed({name: held.texts[name] for name in edited}) for held in (self._bank, bank))
        if len(was) + len(now) > MAX_EVENT_CHARACTERS:
            raise PersonError("the change is too large for a running show", "restart the show to use it")
        if all(section.examples is not None for section in patch.partner):  # else they share clips with the steps
            walk_ahead(bank, "answers")
        self._bank, self.problem = bank, ""
        self.last_change = f"new examples: {', '.join(edited)}: {weights_text(bank)}"
        self._offer(bank)
        self._post(ExamplesChanged(time=self._now(), source="examples", was=was, now=now, bank=bank.digest()))
        return True

    def facts(self) -> dict[str, Any]:
        """Return figures for the status."""
        return {"problem": self.problem, "last_change": self.last_change}


def _packed(texts: dict[str, str]) -> str:
    return compress_text(json.dumps(texts))


def weights_text(bank: ExampleBank) -> str:
    """Return in words how many recordings there are, and which of them count less than the others (H026)."""
    names: dict[str, float] = {}
    for index in range(len(bank.example_sets)):
        names |= bank.weights(index)
    less = sorted((weight, name) for name, weight in names.items() if weight < 1.0)
    told = ", ".join(f"{name} {weight:g}" for weight, name in less[:MAX_LISTED])
    more = f" and {len(less) - MAX_LISTED} more" if len(less) > MAX_LISTED else ""
    return f"{len(names)} recordings" + (f"; these count less: {told}{more}" if less else ", all of them count alike")
