"""What is wrong with a field of a recording, in our own words: what is expected, and what was found."""

import difflib
from types import NoneType, UnionType
from typing import Annotated, Any, Final, Literal, Union, get_args, get_origin, get_type_hints

from live.library.recording import Recording

EXAMPLE: Final = 'file = "walk.bvh", name = "walk", bpm = 120, first_beat_s = 0.5, measures = 2 (a line each)'
_HINTS: Final = get_type_hints(Recording, include_extras=True)


def problem_words(problem: Any) -> str:
    """One of the problems that pydantic found in a Recording."""
    kind, read, field = problem["type"], problem["input"], str(problem["loc"][0]) if problem["loc"] else ""
    if kind == "extra_forbidden":
        keys = list(Recording.model_fields)
        near = difflib.get_close_matches(field, keys, n=1)
        hint = f"did you mean {near[0]!r}? " if near else ""
        return f"unknown key; {hint}allowed are {', '.join(keys)}"
    if kind == "missing":
        return f"missing; it must be given, as in {EXAMPLE}"
    if kind == "string_pattern_mismatch":
        return (
            f"a text that is not blank, without line breaks and other control characters, expected, found {found(read)}"
        )
    return f"{expected(field, inside=len(problem['loc']) > 1)} expected, found {found(read)}"


def found(value: object) -> str:
    """What was read, short enough for a message."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str | int | float):
        return repr(value) if len(repr(value)) <= 60 else repr(value)[:57] + "..."
    return (
        "a list" if isinstance(value, list) else "a table" if isinstance(value, dict) else f"a {type(value).__name__}"
    )


def expected(field: str, *, inside: bool = False) -> str:
    """What may stand for a field; `inside`: for one element of its list."""
    return _described(_HINTS.get(field), inside)


def _described(hint: Any, inside: bool) -> str:
    if get_origin(hint) in (Union, UnionType):
        return _described(next(one for one in get_args(hint) if one is not NoneType), inside)
    kind, low, high, above = hint, None, None, None
    if get_origin(hint) is Annotated:
        kind, *notes = get_args(hint)
        for note in notes:
            for rule in getattr(note, "metadata", []):
                low = getattr(rule, "ge", getattr(rule, "min_length", low))
                high = getattr(rule, "le", getattr(rule, "max_length", high))
                above = getattr(rule, "gt", above)
    if get_origin(kind) is list:
        if inside:
            return _described(get_args(kind)[0], False)
        return f'a list of at most {high} texts, like ["slow", "low"],'
    if get_origin(kind) is Literal:
        return " or ".join(f'"{value}"' for value in get_args(kind))
    if kind is bool:
        return "true or false"
    if kind is str:
        return "a text in quotes" if high is None else f"a text in quotes of {low} to {high} characters"
    number = "a whole number" if kind is int else "a number"
    return f"{number} above {above:g} and up to {high:g}" if above is not None else f"{number} from {low:,} to {high:,}"
