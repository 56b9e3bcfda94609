"""Execution of `live couple compare` and `notation`: recorded couples against the answers to their leaders."""

import json
import time
from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

from live.base.arrays import Float64
from live.base.errors import PersonError
from live.library.partner_pairs import PartnerExamples, RecordedSide, read_pairs
from live.library.pattern_labels import NO_LABELS, PatternLabels, labels_path, read_labels
from live.library.whole_file import write_atomically
from live.motion.clip import Clip
from live.motion.partner.couple_comparison import (
    ComparedDance,
    Count,
    CoupleComparison,
    LabelSpan,
    compare_couples,
    danced_labels,
    transition_cuts,
)
from live.motion.partner.couple_states import PATTERN_BEATS, TRANSITION_BEATS, recognise_states, transitions
from live.motion.partner.notation import CountNotation, notate, notation_text
from live.motion.partner.partner_synthesis import PartnerResult, SearchSettings, find_partner
from live.motion.partner.point_clouds import ends_cloud, leader_cloud
from live.motion.partner.units import Units, cut_units
from live.motion.partner_live.follower_filter import expected_follower


@dataclass(frozen=True, slots=True)
class CompareOptions:
    """Options of the command, each checked on its own."""

    pairs: Path
    take: str | None
    """Name of the take, or its number from 1; None: all in turn."""
    online: bool = False
    style: str | None = None
    first: int = 1
    """Number of the beat that is a one, from 1."""
    labels: Path | None = None
    film: Path | None = None
    report: Path | None = None
    notation: Path | None = None
    size: tuple[int, int] = (1280, 720)
    fps: float = 30.0


@dataclass(frozen=True, slots=True, eq=False)
class AnsweredTake:
    """One take, and the answer to its leader from the other takes."""

    name: str
    leader: Clip
    real: ComparedDance
    answer: ComparedDance
    found: PartnerResult
    units: Units
    beats: Float64
    """Samples of all beats."""
    labels: tuple[LabelSpan, ...]
    comparison: CoupleComparison


def run_compare(options: CompareOptions, console: Console) -> None:
    """Compare, print the table and write what is asked for."""
    known = read_pairs(options.pairs, style=options.style)
    labels = _labels(options)
    chosen = chosen_takes(known, options.take)
    if options.film is not None and len(chosen) > 1:
        raise PersonError("--film: a film shows one take", f"--take {known.units.examples[0].name}")
    if len(known.leaders) < 2:
        raise PersonError(f"{options.pairs}: one pair; a take is answered from the others", "two pairs at least")
    made = [_answer(known, take, labels, options) for take in chosen]
    for one in made:
        print(take_text(one))
    if len(made) > 1:
        print(total_text(made))
    if not any(one.comparison.labelled for one in made):
        print(
            f"No labels of a person ({labels_path(options.pairs).name}): the patterns are recognised stances and "
            f"turns. `live couple label {options.pairs}` is the page to set labels."
        )
    if options.report is not None:
        told = {"takes": [_told(one, options) for one in made], "labels_by_a_person": labels is not NO_LABELS}
        write_atomically((json.dumps(told, indent=1) + "\n").encode(), options.report, "--report")
    if options.notation is not None:
        text = "\n".join(f"# {one.name}, the answer\n{_answer_notation(one, options)}" for one in made)
        write_atomically(text.encode(), options.notation, "--notation")
    if options.film is not None:
        from live.app.film.couple_film import film_couple

        film_couple(_film(made[0], options), options.film, size=options.size, fps=options.fps, console=console)
        print(f"the film is here: {options.film.resolve()}")


def chosen_takes(known: PartnerExamples, take: str | None) -> list[int]:
    """Return the indices of the takes that are named, or of all; PersonError if there is none of that name."""
    if known.leaders[0] is None:
        raise PersonError(f"{known.file} holds walks, which have no leader", "a file of pairs with leaders")
    names = [one.name for one in known.units.examples]
    if take is None:
        return list(range(len(names)))
    if take in names:
        return [names.index(take)]
    if take.isdecimal() and 1 <= int(take) <= len(names):
        return [int(take) - 1]
    raise PersonError(f"--take {take!r}: there is no such take", f"there are: {', '.join(names[:20])}")


def _labels(options: CompareOptions) -> PatternLabels:
    if options.labels is not None:
        return read_labels(options.labels)
    usual = labels_path(options.pairs)
    return read_labels(usual) if usual.exists() else NO_LABELS


def _answer(known: PartnerExamples, take: int, labels: PatternLabels, options: CompareOptions) -> AnsweredTake:
    examples = known.units.examples
    example, side = examples[take], known.leaders[take]
    assert side is not None  # checked with the takes
    units = cut_units([one for n, one in enumerate(examples) if n != take])
    leader, rate = side.clip, side.clip.sample_rate
    search = SearchSettings()
    if len(example.beats) > 1:
        search = replace(search, beats=example.beats / rate)
    if options.online:
        from live.motion.partner_live.live_partner import evaluate_live

        found, _ = evaluate_live(leader, ends_cloud(leader), units, search, time.thread_time)
    else:
        expected = expected_follower(leader_cloud(leader), units)
        found = find_partner(leader, ends_cloud(leader), units, search, expected=expected)
    last = min(leader.sample_count, found.clip.sample_count) - 1.0
    cuts = transition_cuts(example.beats, last, first=options.first - 1, beats_each=TRANSITION_BEATS)
    dances = []
    for follower in (known.followers[take].clip, found.clip):
        states = recognise_states(leader, follower)
        dances.append(ComparedDance(follower, states, transitions(states, cuts)))
    spans = tuple(LabelSpan(one.from_s, one.to_s, one.label) for one in labels.of(example.name))
    danced = danced_labels(found.reading, units, labels.at)
    comparison = compare_couples(leader, dances[0], dances[1], spans, danced)
    return AnsweredTake(
        example.name, leader, dances[0], dances[1], found, units, example.beats, spans, comparison
    )  # fmt: skip


def _share(count: Count) -> str:
    return "-" if count.share is None else f"{100.0 * count.share:.0f} % ({count.same} of {count.of})"


def take_text(one: AnsweredTake) -> str:
    """Return the table of one take: its figures, and each pattern."""
    told = one.comparison
    rows = [("", "from", "to [s]", "joints [m]", "facing [°]", "real", "answer")]
    for pattern in told.patterns:
        mark = "=" if pattern.whole else "~" if pattern.same else " " if pattern.known else "?"
        rows.append((
            mark, f"{pattern.begin:.2f}", f"{pattern.end:.2f}", f"{pattern.joint_m:.2f}", f"{pattern.facing_deg:.0f}",
            pattern.real, pattern.answer,
        ))  # fmt: skip
    wide = [max(len(row[n]) for row in rows) for n in range(7)]
    lines = ["  ".join(word.ljust(size) for word, size in zip(row, wide, strict=True)).rstrip() for row in rows]
    return "\n".join([f"{one.name}: {total_text([one])}", *lines, ""])


def usual_count(takes: list[AnsweredTake]) -> Count:
    """Return how many transitions of the real followers are their most frequent one: who always danced that one, would
    agree as often."""
    real = Counter(each.words for one in takes for each in one.real.transitions)
    return Count(max(real.values(), default=0), sum(real.values()))


def total_text(takes: list[AnsweredTake]) -> str:
    """Return the figures of one take, or the means of several, in a few lines."""
    many = [one.comparison for one in takes]
    means = {name: float(np.mean([getattr(one, name) for one in many])) for name in _MEANS}
    counts = {name: sum((getattr(one, name) for one in many), Count(0, 0)) for name in _COUNTS}
    label = "patterns (labels of a person)" if any(one.labelled for one in many) else "patterns (recognised)"
    heading = f"all {len(many)} takes: " if len(many) > 1 else ""
    lines = [
        f"{heading}joints {means['joint_m']:.3f} m ({means['aligned_m']:.3f} aligned), hips "
        f"{means['hip_distance_m']:.3f} m, facing {means['facing_deg']:.0f}°, more than 90° off in "
        f"{100.0 * means['turned_share']:.0f} % of the time",
        f"  the same stance {_share(counts['stance'])} of the samples, open or closed {_share(counts['embrace'])}",
        f"  turns (F1) {_share(counts['turns'])}, of these the same kind {_share(counts['turn_kinds'])}",
        f"  transitions {_share(counts['transitions'])}, the most frequent one alone {_share(usual_count(takes))}",
        f"  {label} {_share(counts['pattern_count'])}, wholly {_share(counts['whole_count'])}",
    ]
    labelled = [one.units for one in many if one.units is not None]
    if labelled:
        lines.append(f"  units with the same label {_share(sum(labelled, Count(0, 0)))}")
    return "\n".join(lines)


_MEANS = ("joint_m", "aligned_m", "hip_distance_m", "facing_deg", "turned_share")
_COUNTS = ("stance", "embrace", "turns", "turn_kinds", "transitions", "pattern_count", "whole_count")


def _told(one: AnsweredTake, options: CompareOptions) -> dict[str, Any]:
    """Return the same as values for JSON."""
    told = one.comparison

    def count(values: Count) -> dict[str, Any]:
        return {"same": values.same, "of": values.of, "share": values.share}

    return {
        "take": one.name,
        "online": options.online,
        **{name: getattr(told, name) for name in _MEANS},
        **{name: count(getattr(told, name)) for name in _COUNTS},
        "most_frequent_transition_alone": count(usual_count([one])),
        "labelled": told.labelled,
        "units_with_the_same_label": None if told.units is None else count(told.units),
        "patterns": [
            {
                "from_s": each.begin, "to_s": each.end, "real": each.real,
                "answer": each.answer, "same": each.same, "whole": each.whole,
                "joint_m": each.joint_m, "facing_deg": each.facing_deg,
                "known": each.known,
            }
            for each in told.patterns
        ],
    }  # fmt: skip


def _answer_notation(one: AnsweredTake, options: CompareOptions) -> str:
    counts = notate(
        one.leader, one.answer.follower, one.answer.states, one.beats, counts=PATTERN_BEATS, first=options.first - 1
    )
    reading = one.found.reading
    begins = reading.start / reading.rate
    names = [
        one.units.label(int(reading.unit[max(int(np.searchsorted(begins, each.begin, side="right")) - 1, 0)]))
        for each in counts
    ]
    return notation_text(counts, names=names)


def _film(one: AnsweredTake, options: CompareOptions) -> Any:
    from live.app.film.couple_film import CoupleFilm

    patterns = [(each.begin, each.end, each.real, each.answer) for each in one.comparison.patterns]
    return CoupleFilm(
        one.name, one.leader, one.real, one.answer, one.beats, options.first - 1, PATTERN_BEATS,
        patterns if one.comparison.labelled else (),
    )  # fmt: skip


def run_notation(pairs: Path, take: str | None, *, first: int, out: Path | None, report: Path | None) -> None:
    """Write the notation of recorded couples as a text, printed without `out`, and as JSON."""
    known = read_pairs(pairs)
    texts, told = [], []
    for index in chosen_takes(known, take):
        example, side = known.units.examples[index], known.leaders[index]
        assert side is not None  # checked with the takes
        if len(example.beats) < 2:
            raise PersonError(f"{pairs}: {example.name} has no beats", "give bpm and first_beat_s of the pair")
        counts = _recorded_notation(side, known.followers[index], example.beats, first)
        texts.append(f"# {example.name}\n{notation_text(counts)}")
        told.append({"take": example.name, "counts": [_count_values(one) for one in counts]})
    text = "\n".join(texts)
    if out is None:
        print(text, end="")
    else:
        write_atomically(text.encode(), out, "--out")
    if report is not None:
        write_atomically((json.dumps(told, indent=1) + "\n").encode(), report, "--report")


def _recorded_notation(
    leader: RecordedSide, follower: RecordedSide, beats: Float64, first: int
) -> tuple[CountNotation, ...]:
    states = recognise_states(leader.clip, follower.clip)
    return notate(leader.clip, follower.clip, states, beats, counts=PATTERN_BEATS, first=first - 1)


def _count_values(one: CountNotation) -> dict[str, Any]:
    movements = {
        name: {"support": each.support, "direction": each.direction, "level": each.level, "turn_eighths": each.turn}
        for name, each in (("leader", one.leader), ("follower", one.follower))
    }
    return {
        "time_s": round(one.begin, 4), "count": one.count, **movements, "hands": one.hands or None,
        "stance": one.stance.words, "turn": one.turn or None,
    }  # fmt: skip
