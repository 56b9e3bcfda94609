"""What a choreographer writes, "couru left, échappé x2, *", as the entries of a sequence."""

import difflib
import re
import unicodedata
from typing import Final

from live.base.errors import PersonError
from live.graph.search.sequence_spec import MOST_MEASURES, Wanted, travels
from live.graph.step_library import StepLibrary
from live.motion.step_clip import DIRECTIONS

ANY: Final = "*"
_TIMES: Final = re.compile(r"(?P<what>.+?)\s+[x×]\s*(?P<times>[0-9]{1,200})")
_LENGTH: Final = re.compile(r"(?P<what>.+?)\s*:\s*(?P<measures>[0-9]{1,3})")
_WAYS: Final = tuple(dict.fromkeys([*DIRECTIONS, *(way.split()[-1] for way in DIRECTIONS[1:])]))
"""Ways that may follow a step's name: the nine directions, or only where to."""


def parse_sequence(text: str, library: StepLibrary) -> list[Wanted]:
    """The entries of a sequence: names of steps with commas between them.

    "*" is a measure of anything, "x3" after an entry repeats it, a direction after a name asks for that way, and ":2"
    for the variation of two measures where a step has several lengths. Capitals, accents, blanks and underscores do
    not matter. PersonError names the entry, what was read, and the nearest names.
    """
    wanted: list[Wanted] = []
    parts = text.split(",")
    for number, part in enumerate(parts, start=1):
        where = f"entry {number} of the sequence"
        if not part.strip():
            raise PersonError(f"{where} is empty: the name of a step or {ANY} expected", known(library))
        what, times = _repeats(part.strip(), library)
        measures = len(wanted) + times  # at least: no entry is shorter than a measure
        if times < 1 or measures > MOST_MEASURES:
            raise PersonError(
                f"{where}, {_short(part)}: 1 to {MOST_MEASURES} measures in all expected",
                "fewer repeats" if times else "leave the entry out",
            )
        wanted += [_entry(what, library, where)] * times
    return wanted


def find_name(library: StepLibrary, name: str) -> int | None:
    """Index of the step called `name`; accents do not matter either, unless two steps differ in nothing else."""
    index = library.step_index(name)
    if index is None:
        plain = [_unaccented(step) for step in library.steps]
        if plain.count(_unaccented(name)) == 1:
            index = plain.index(_unaccented(name))
    return index


def known(library: StepLibrary, count: int = 12) -> str:
    """The names of the steps that there are, the first few of many."""
    return "the steps are " + ", ".join(library.steps[:count]) + (", ..." if len(library.steps) > count else "")


def _repeats(part: str, library: StepLibrary) -> tuple[str, int]:
    """An entry without its repeats, and how many there are; a step may itself be called "wave x2"."""
    match = _TIMES.fullmatch(part)
    if match is None or find_name(library, part) is not None:
        return part, 1
    return match["what"], int(match["times"])


def _entry(what: str, library: StepLibrary, where: str) -> Wanted:
    if what == ANY:
        return Wanted(None)
    step, way, measures = find_name(library, what), "", None
    if step is None and (match := _LENGTH.fullmatch(what)) is not None:
        what, measures = match["what"], int(match["measures"])
        step = find_name(library, what)
    if step is None:
        what, way = _way(what)
        step = find_name(library, what)
    if step is None:
        raise _unknown(what, library, where)
    lengths = sorted({clip.measures for clip in library.clips if clip.step == library.steps[step]})
    if way:
        lengths = sorted({c.measures for c in library.clips if c.step == library.steps[step] and travels(c, way)}) or (
            lengths
        )
    if measures is not None and measures not in lengths:
        unit = "measure" if lengths == [1] else "measures"
        raise PersonError(
            f"{where}: {library.steps[step]!r} is {_listed(lengths)} {unit} long, not {measures}",
            f"{library.steps[step]}:{lengths[0]}",
        )
    if measures is None and len(lengths) > 1:
        raise PersonError(
            f"{where}: variations of {library.steps[step]!r} are {_listed(lengths)} measures long: say which",
            f"{library.steps[step]}:{lengths[0]}",
        )
    return Wanted(step, measures or lengths[0], way)


def _way(what: str) -> tuple[str, str]:
    """Name and direction of "walk long left"; no direction if there is none at the end."""
    plain = " ".join(what.casefold().replace("_", " ").split())
    for way in _WAYS:
        if plain.endswith(" " + way):
            return plain[: -len(way)].strip(), way
    return what, ""


def _unknown(name: str, library: StepLibrary, where: str) -> PersonError:
    plain = {_unaccented(step): step for step in library.steps}
    near = [plain[found] for found in difflib.get_close_matches(_unaccented(name), plain, n=3)]
    return PersonError(f"{where}: there is no step {_short(name)}", " or ".join(near) if near else known(library))


def _short(text: str) -> str:
    text = " ".join(text.split())
    return repr(text if len(text) <= 60 else text[:60] + "…")


def _listed(lengths: list[int]) -> str:
    return " or ".join(map(str, lengths))


def _unaccented(name: str) -> str:
    letters = unicodedata.normalize("NFKD", name.replace("_", " ").replace("-", " ").casefold())
    return " ".join("".join(letter for letter in letters if not unicodedata.combining(letter)).split())
