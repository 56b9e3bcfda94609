"""What `live steps cut` does: finds steps, prints them, writes the sheet, adds what is accepted."""

import json
import math
import re
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from shlex import quote
from typing import Any

from rich.console import Console
from rich.table import Table

from live.app.offline.step_adding import ClapReference, check_beat_options, print_beats
from live.app.offline.step_listing import user_library
from live.base.errors import PersonError
from live.library.add_step import with_beats
from live.library.vocabulary import (
    AddedSteps,
    ProposedStep,
    Vocabulary,
    add_vocabulary,
    find_vocabulary,
    renamed,
)
from live.library.vocabulary_sheet import places_text, sheet_page
from live.library.whole_file import write_atomically
from live.motion.beats.music_reference import MusicReference


@dataclass(frozen=True, slots=True, kw_only=True)
class CutRequest:
    """The command's arguments."""

    files: tuple[Path, ...]
    fields: Mapping[str, Any]
    """Fields of every recording."""
    reference: ClapReference
    accept: str | None
    sheet: Path | None
    rename: tuple[str, ...]
    takes: int
    library: Path | None
    alike: float
    longest: int
    json: bool


def cut_recordings(request: CutRequest) -> None:
    """Run the command; PersonError for wrong arguments, and for recordings that cannot be cut."""
    console = Console(highlight=False, stderr=request.json)
    check_beat_options(dict(request.fields), request.reference)
    folder = user_library() if request.library is None else request.library

    def beats(file: Path, fields: dict[str, Any]) -> tuple[dict[str, Any], Mapping[str, str], MusicReference | None]:
        if "bpm" in fields and "first_beat_s" in fields:
            return fields, {}, None
        reference = request.reference
        told, comments, found = with_beats(
            file, fields, click=reference.click, count=reference.count, song=reference.song
        )
        console.print(f"{file.name}:", end=" ", markup=False)
        print_beats(console, found)
        return told, comments, found.reference if found.reference.source == "feet" else None

    vocabulary = find_vocabulary(
        request.files, request.fields, beats, alike=request.alike, longest=request.longest, library=folder
    )
    vocabulary = renamed(vocabulary, parse_names(request.rename), folder)
    chosen = [] if request.accept is None else chosen_steps(vocabulary, request.accept)
    if request.sheet is not None:
        write_atomically(sheet_page(vocabulary, _command("all")).encode(), request.sheet, "--sheet")
    added = add_vocabulary(folder, vocabulary, chosen, request.takes) if request.accept is not None else None
    if request.json:
        json.dump(_json(vocabulary, added), sys.stdout, ensure_ascii=False)
        sys.stdout.write("\n")
        return
    if added is None:
        console.print(_table(vocabulary))
    if request.sheet is not None:
        console.print(f"sheet:   {request.sheet}", soft_wrap=True, markup=False)
    if added is None:
        console.print(f"add them: {_command('all')}", style="dim", soft_wrap=True, markup=False)
        return
    known = f"; {added.known} were there already" if added.known else ""
    console.print(f"added {len(added.steps)} steps with {added.cuts} takes{known}", style="green", markup=False)
    for toml in added.tomls:
        console.print(f"written: {toml}", soft_wrap=True, markup=False)
    console.print(f"dance them:  live play --steps {quote(str(folder))}", style="dim", soft_wrap=True, markup=False)


def _command(accept: str) -> str:
    """Return the command as given, with the steps to be added."""
    words, kept = iter(sys.argv[1:]), []
    for word in words:
        option = word.partition("=")[0]
        if option in ("--accept", "--sheet"):
            if option == word:
                next(words, None)
        elif word != "--json":
            kept.append(word)
    return f"live {' '.join(map(quote, kept))} --accept {accept}"


def parse_names(rename: tuple[str, ...]) -> dict[int, str]:
    """Return names by number from texts such as "3=samba roll"; PersonError for other texts."""
    names: dict[int, str] = {}
    for text in rename:
        found = re.fullmatch(r"\s*(\d{1,6})\s*=\s*(\S.{0,63})", text)
        if found is None:
            raise PersonError(f"--rename {text[:60]!r}: a number and a name expected", '--rename "3=samba roll"')
        names[int(found[1])] = found[2].strip()
    return names


def chosen_steps(vocabulary: Vocabulary, accept: str) -> list[ProposedStep]:
    """Return the accepted steps: "all", "repeated", or numbers and ranges from 1; PersonError for anything else."""
    steps = vocabulary.steps
    match accept.strip().casefold():
        case "all":
            return list(steps)
        case "repeated":
            chosen = [step for step in steps if len(step.found.starts) > 1]
            if not chosen:
                raise PersonError("--accept repeated: no step is danced more than once", "--accept all")
            return chosen
    numbers: set[int] = set()
    for part in accept.split(","):
        found = re.fullmatch(r"\s*(\d{1,6})\s*(?:-\s*(\d{1,6})\s*)?", part)
        first, last = (0, 0) if found is None else (int(found[1]), int(found[2] or found[1]))
        if not 1 <= first <= last <= len(steps):
            raise PersonError(
                f"--accept {accept[:60]!r}: numbers from 1 to {len(steps)} expected", "--accept all, or --accept 1,3-5"
            )
        numbers.update(range(first, last + 1))
    return [steps[number - 1] for number in sorted(numbers)]


def _table(vocabulary: Vocabulary) -> Table:
    table = Table(box=None, pad_edge=False, header_style="bold")
    for name, justify in (
        ("", "right"), ("step", "left"), ("measures", "right"), ("times", "right"), ("travel", "right"),
        ("turn", "right"), ("bpm", "right"), ("where", "left"),
    ):  # fmt: skip
        table.add_column(name, justify=justify)  # type: ignore[arg-type]
    for number, step in enumerate(vocabulary.steps, 1):
        row = _row(vocabulary, step)
        table.add_row(
            str(number), row["name"], str(row["measures"]), str(row["times"]), f"{row['travel_m']:.2f} m",
            f"{row['turn_deg']:+.0f}°", f"{row['bpm']:g}", places_text(vocabulary, step),
        )  # fmt: skip
    return table


def _row(vocabulary: Vocabulary, step: ProposedStep) -> dict[str, Any]:
    facts, found = step.facts, step.found
    return {
        "name": step.name,
        "measures": found.measures,
        "times": len(found.starts),
        "spread_m": round(found.spread_m, 4),
        "travel_m": round(facts.distance_m, 3),
        "turn_deg": round(math.degrees(facts.turn), 1),
        "bpm": round(60.0 * vocabulary.measures.beats * found.measures / facts.seconds, 2),
        "places": [
            {"file": take.name, "measure": number} for take, number in map(vocabulary.place, sorted(found.starts))
        ],
    }


def _json(vocabulary: Vocabulary, added: AddedSteps | None) -> dict[str, Any]:
    out: dict[str, Any] = {
        "recordings": [
            {
                "file": take.name,
                "bpm": take.entry.recording.bpm,
                "first_beat_s": take.entry.recording.first_beat_s,
                "measures": len(take.lines) - 1,
                "guessed": bool(take.comments),
            }
            for take in vocabulary.takes
        ],
        "steps": [_row(vocabulary, step) for step in vocabulary.steps],
    }
    if added is not None:
        out["added"] = {"steps": [step.name for step in added.steps], "takes": added.cuts, "known": added.known}
    return out
