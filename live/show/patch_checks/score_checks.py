"""Checks of a written score before it runs, with errors that name the keys (T015).

Each check yields all its errors.
"""

import math
from collections.abc import Iterator, Sequence
from typing import Any, Final

from live.show.patch.patch import Patch
from live.show.patch.section_base import InvalidEntry
from live.show.patch.section_music import CURVE_PREFIX, UNIT_PREFIX
from live.show.patch_checks.call_response_check import check_call_response
from live.show.score.section_span import score_length, span_of

PLACED_TABLES: Final = ("element", "segment", "regroup", "sequence", "improvise", "at", "signal", "curve")
"""Tables whose entries have a measure, and may have a section."""
LENIENT_TABLES: Final = ("segment", "regroup")
"""Tables for which a measure after `loop_measures` was always allowed."""


def check_score(patch: Patch) -> Iterator[InvalidEntry]:
    """Yield the errors of the score."""
    lengths: dict[str, int] = {}
    yield from _check_sections(patch, lengths)
    length = score_length(patch) or math.inf
    for kind in PLACED_TABLES:
        any_measure = kind in LENIENT_TABLES and not patch.section
        for index, entry in enumerate(getattr(patch, kind)):
            if entry.section is not None:
                yield from _section_faults(patch, lengths, kind, index, entry)
            elif not any_measure and entry.measure is not None and int(entry.measure) > length:
                words = f"measure {entry.measure:g}: the score has {length:g} measures, it would never begin"
                yield InvalidEntry(words, kind, index, "measure")
    yield from _check_beats(patch)
    yield from _check_groups(patch)
    yield from _check_improvised(patch)
    yield from check_call_response(patch)
    yield from _check_signals(patch)
    yield from _check_curves(patch)
    yield from _check_calls(patch, set(lengths))


def _check_sections(patch: Patch, lengths: dict[str, int]) -> Iterator[InvalidEntry]:
    """Fill in the measures of each section by its name."""
    for index, section in enumerate(patch.section):
        name = section.name.casefold()
        if name in lengths:
            yield InvalidEntry(
                f"two sections are called {section.name!r}: give each its own name", "section", index, "name"
            )
        lengths[name] = section.measures
    if patch.section and patch.loop_measures is not None:
        yield InvalidEntry(
            "loop_measures and [[section]]: leave loop_measures out; after its last section a score begins again",
            "loop_measures",
        )
    for index, section in enumerate(patch.section):
        if section.then is not None and section.then.casefold() not in (*lengths, "end"):
            known = ", ".join(["end", *(one.name for one in patch.section)])
            words = f"no section is called {section.then!r}; there are: {known}"
            yield InvalidEntry(words, "section", index, "then")


def _section_faults(patch: Patch, lengths: dict[str, int], kind: str, index: int, entry: Any) -> Iterator[InvalidEntry]:
    """Yield the error of an entry whose section does not exist, or ends before it."""
    if entry.measure is None:
        return
    length = lengths.get(entry.section.casefold())
    if length is None:
        known = ", ".join(section.name for section in patch.section) or "none: write [[section]]"
        yield InvalidEntry(f"no section is called {entry.section!r}; there are: {known}", kind, index, "section")
    elif int(entry.measure) > length:
        words = f"measure {entry.measure:g}: section {entry.section!r} has {length} measures, it would never begin"
        yield InvalidEntry(words, kind, index, "measure")


def _check_beats(patch: Patch) -> Iterator[InvalidEntry]:
    beats = patch.clock.beats_per_measure
    placed: tuple[tuple[str, Sequence[Any]], ...] = (("at", patch.at), ("signal", patch.signal))
    for kind, entries in placed:
        for index, entry in enumerate(entries):
            if entry.beat >= beats + 1:
                words = (
                    f"beat {entry.beat:g}: a measure of this show has {beats} beats, so less than {beats + 1} expected"
                )
                yield InvalidEntry(words, kind, index, "beat")


def _check_groups(patch: Patch) -> Iterator[InvalidEntry]:
    names = {group.name.casefold() for group in patch.group}
    known = ", ".join(group.name for group in patch.group)
    for index, entry in enumerate(patch.improvise):
        if entry.answers is not None and entry.answers.casefold() not in names:
            yield InvalidEntry(
                f"no group is called {entry.answers!r}; there are: {known}", "improvise", index, "answers"
            )


def _check_improvised(patch: Patch) -> Iterator[InvalidEntry]:
    """Yield an error if two improvisations of one group overlap, or if one lasts longer than its section."""
    taken: dict[tuple[int, str], list[tuple[int, float, int]]] = {}
    for index, entry in enumerate(patch.improvise):
        stay = span_of(patch, entry.section, entry.measure, entry.measures)
        if stay.size is not None and entry.measures is not None and stay.begin + entry.measures > stay.size:
            last = stay.first + stay.size if entry.section is None else stay.size
            words = f"measures {entry.measures} from measure {entry.measure} on: its section ends with {last}"
            yield InvalidEntry(words, "improvise", index, "measures")
        groups = [group.name.casefold() for group in patch.group] if entry.group == "*" else [entry.group.casefold()]
        for group in groups:
            for other_begin, other_end, other in taken.setdefault((stay.section, group), []):
                if stay.begin < other_end and other_begin < stay.end:
                    yield InvalidEntry(
                        f"group {group!r} improvises already there, as improvise {other + 1} says: end one of them "
                        "with measures, or leave one out",
                        *("improvise", index, "measure"),
                    )
            taken[stay.section, group].append((stay.begin, stay.end, index))


def _check_signals(patch: Patch) -> Iterator[InvalidEntry]:
    known = signals_of(patch)
    calls: dict[str, set[str]] = {}
    for index, reaction in enumerate(patch.react):
        if reaction.on is None:
            continue
        name = reaction.on.casefold()
        if name.startswith(UNIT_PREFIX) and name != UNIT_PREFIX:
            if not patch.partner:
                yield InvalidEntry(f"{reaction.on!r}: there is no partner: write [[partner]]", "react", index, "on")
            continue
        if name not in known:
            words = (
                f"no signal is called {reaction.on!r}: name it in a [[signal]] or [[gesture]]; "
                f"there are: {', '.join(sorted(known))}"
            )
            yield InvalidEntry(words, "react", index, "on")
            continue
        if reaction.call == "/dance/signal" and reaction.when != "measure":
            given = str(reaction.values[0]).casefold()
            calls.setdefault(name, set()).add(given)
            if name in _triggered_signals(calls, given):
                words = f'signal {name!r} would give itself again and again: when = "measure" for one of them'
                yield InvalidEntry(words, "react", index, "values")


def _check_curves(patch: Patch) -> Iterator[InvalidEntry]:
    names = {curve.name.casefold().strip() for curve in patch.curve}
    known = ", ".join(sorted({curve.name for curve in patch.curve})) or "none: write [[curve]]"
    for index, reaction in enumerate(patch.react):
        name = (reaction.to or "").removeprefix(CURVE_PREFIX)
        if reaction.is_curve and name.casefold().strip() not in names:
            yield InvalidEntry(f"no curve is called {name!r}; there are: {known}", "react", index, "to")
    for index, signal in enumerate(patch.signal):
        if signal.curve is not None and signal.curve.casefold().strip() not in names:
            yield InvalidEntry(f"no curve is called {signal.curve!r}; there are: {known}", "signal", index, "curve")


def signals_of(patch: Patch) -> set[str]:
    """Return all signals that can occur, by their folded names."""
    known = {"drop", "build", *(one.name.casefold() for one in patch.signal)}
    known |= {one.name.casefold() for one in patch.gesture}
    return known | {one.signal.casefold() for one in patch.at if one.signal is not None}


def _triggered_signals(calls: dict[str, set[str]], name: str) -> set[str]:
    """The signals that one triggers, directly or through others, itself included."""
    found, more = {name}, [name]
    while more:
        new = calls.get(more.pop(), set()) - found
        found |= new
        more += new
    return found


def _check_calls(patch: Patch, sections: set[str]) -> Iterator[InvalidEntry]:
    """Yield an error for a call that jumps to an unknown section."""
    for call, values, place in calls_of(patch):
        if call == "/dance/section" and str(values[0]).casefold() not in sections:
            known = ", ".join(section.name for section in patch.section) or "none: write [[section]]"
            yield InvalidEntry(f"no section is called {values[0]!r}; there are: {known}", *place)


CallEntry = tuple[str, tuple[Any, ...], tuple[str | int, ...]]
"""A call: address, values, and the keys that lead to the values."""


def calls_of(patch: Patch) -> Iterator[CallEntry]:
    """Yield every call of a patch's score and cues."""
    for index, at in enumerate(patch.at):
        if at.call is not None:
            yield at.call, at.values, ("at", index, "values")
    for index, reaction in enumerate(patch.react):
        if reaction.call is not None:
            yield reaction.call, reaction.values, ("react", index, "values")
    for index, improvised in enumerate(patch.improvise):
        for row, item in enumerate(improvised.motion):
            if item.call is not None:
                yield item.call, item.values, ("improvise", index, "motion", row, "values")
    for index, cue in enumerate(patch.cue):
        for row, call in enumerate(cue.calls):
            yield str(call[0]), tuple(call[1:]), ("cue", index, "calls", row)
