"""Parser for the notation of sketches: counts ("2&") and phrases of a part ("out 18, forward 4").

Amounts are converted to metres and radians. Sides are the dancer's left and right; `out` is away from the body.
"""

import difflib
import math
import re
from collections.abc import Mapping
from typing import Final

CENTIMETRE: Final = 0.01
DEGREE: Final = math.pi / 180.0
MAX_CENTIMETRES: Final = 300.0
MAX_DEGREES: Final = 180.0
MAX_BODY_DEGREES: Final = 1080.0

Vocabulary = Mapping[str, tuple[str, float]]
"""Phrase → its channel and the factor from the written number to metres or radians; 0 for words without a number."""

_SHIFT: Final = {
    "up": ("up", CENTIMETRE),
    "down": ("up", -CENTIMETRE),
    "left": ("left", CENTIMETRE),
    "right": ("left", -CENTIMETRE),
    "forward": ("forward", CENTIMETRE),
    "back": ("forward", -CENTIMETRE),
}
_TURN: Final = {
    "turn left": ("turn", DEGREE),
    "turn right": ("turn", -DEGREE),
    "lean forward": ("lean", DEGREE),
    "lean back": ("lean", -DEGREE),
    "tilt left": ("tilt", DEGREE),
    "tilt right": ("tilt", -DEGREE),
}
_NEUTRAL: Final = {"neutral": ("neutral", 0.0)}


def _limb(side: float) -> dict[str, tuple[str, float]]:
    return {
        "out": ("out", CENTIMETRE),
        "in": ("out", -CENTIMETRE),
        "left": ("out", side * CENTIMETRE),
        "right": ("out", -side * CENTIMETRE),
        "forward": ("forward", CENTIMETRE),
        "back": ("forward", -CENTIMETRE),
        "up": ("up", CENTIMETRE),
    }


def _foot(side: float) -> Vocabulary:
    return _limb(side) | {
        "heel": ("heel", CENTIMETRE),
        "toe": ("toe", CENTIMETRE),
        "lift": ("lift", CENTIMETRE),
        "turn out": ("turn", DEGREE),
        "turn in": ("turn", -DEGREE),
        "touch": ("touch", 0.0),
        "home": ("home", 0.0),
    }


def _hand(side: float) -> Vocabulary:
    words = _limb(side) | {"down": ("up", -CENTIMETRE), "rest": ("rest", 0.0)}
    words |= {f"elbow {word}": (f"elbow {channel}", factor) for word, (channel, factor) in words.items() if factor}
    return words | {
        "wrist up": ("wrist", DEGREE),
        "wrist down": ("wrist", -DEGREE),
        "turn out": ("turn", DEGREE),
        "turn in": ("turn", -DEGREE),
    }


_SHOULDER: Final = {word: _SHIFT[word] for word in ("up", "down", "forward", "back")}

PARTS: Final[Mapping[str, Vocabulary]] = {
    "body": {word: _TURN[word] for word in ("turn left", "turn right")},
    "pelvis": _SHIFT | _TURN | _NEUTRAL,
    "chest": {word: _SHIFT[word] for word in ("left", "right", "forward", "back")} | _TURN | _NEUTRAL,
    "head": _TURN | _NEUTRAL,
    "left_shoulder": _SHOULDER | _NEUTRAL,
    "right_shoulder": _SHOULDER | _NEUTRAL,
    "left_hand": _hand(1.0),
    "right_hand": _hand(-1.0),
    "left_foot": _foot(1.0),
    "right_foot": _foot(-1.0),
}
"""The words of each part of the body."""

PAIRS: Final = {"shoulders": "shoulder", "hands": "hand", "feet": "foot"}
"""Tables for both sides at once, without the ambiguous words `left` and `right`."""

_COUNT: Final = re.compile(r"(\d{1,3})(&|e|a|\.\d{1,6})?")
_FRACTION: Final = {None: 0.0, "&": 0.5, "e": 0.25, "a": 0.75}
_NUMBER: Final = re.compile(r"[+-]?\d{1,9}(\.\d{0,9})?")


class NotationError(ValueError):
    """An invalid count or phrase, with problem and remedy."""

    def __init__(self, problem: str, remedy: str) -> None:
        super().__init__(problem)
        self.problem = problem
        self.remedy = remedy


def read_counts(text: str, beats: float) -> list[float]:
    """Return beats from 0 of one or more counts, e.g. ``"1"``, ``"2&"`` or ``"1e 2e 3.33"``; raises NotationError."""
    counts = text.replace(",", " ").split()
    if not counts:
        raise NotationError("names no count", 'write the count as "1", "1&", "1e", "1a" or "2.33"')
    return [_read_count(count, beats) for count in counts]


def _read_count(count: str, beats: float) -> float:
    found = _COUNT.fullmatch(count)
    if found is None:
        raise NotationError(f'"{count}" is no count', 'write the count as "1", "1&", "1e", "1a" or "2.33"')
    mark = found.group(2)
    beat = int(found.group(1)) - 1 + (_FRACTION[mark] if mark in _FRACTION else float(f"0{mark}"))
    if not 0.0 <= beat < beats:
        last = f"{beats:g}"
        raise NotationError(f'count "{count}" is outside the step', f'counts go from "1" to just before "{last}" + 1')
    return beat


def read_phrases(text: str, part: str, words: Vocabulary) -> dict[str, float]:
    """Channel → amount of a line such as ``"out 18, forward 4"`` (metres, radians; flags 1); raises NotationError."""
    amounts: dict[str, float] = {}
    for phrase in text.split(","):
        channel, amount = _read_phrase(" ".join(phrase.split()), part, words)
        if channel in amounts:
            raise NotationError(f'"{phrase.strip()}" says again what the same line has said', "keep one of the two")
        amounts[channel] = amount
    _check_conflicts(amounts, part)
    return amounts


def _check_conflicts(amounts: Mapping[str, float], part: str) -> None:
    alone = [flag for flag in ("neutral", "rest") if flag in amounts]
    if alone and len(amounts) > 1:
        raise NotationError(f'"{alone[0]}" says everything', "leave out the other words of the line")
    if "home" in amounts and {"out", "forward"} & set(amounts):
        raise NotationError('"home" is a place', "leave out home, or out, in, forward and back")
    if "foot" in part or part == "feet":
        for word in ("up", "heel", "toe", "lift"):
            if amounts.get(word, 0.0) < 0.0:
                raise NotationError(f"{word} below the floor", f"give {word} a number from 0")
        if "heel" in amounts and "toe" in amounts:
            raise NotationError("heel and toe cannot be lifted at once", "keep one of them")
        if amounts.get("up", 0.0) > 0.0 and {"touch", "lift"} & set(amounts):
            raise NotationError("in the air (up) and on the floor (touch, lift) at once", "keep one of them")


def _read_phrase(phrase: str, part: str, words: Vocabulary) -> tuple[str, float]:
    name, _, number = phrase.rpartition(" ")
    if phrase in words:
        channel, factor = words[phrase]
        if factor == 0.0:
            return channel, 1.0
        raise NotationError(f'"{phrase}" lacks its number', f'say how much, e.g. "{phrase} 5"')
    if name not in words or words[name][1] == 0.0:
        raise NotationError(f'"{phrase}" is not understood for {part}', _suggest(name or phrase, words))
    channel, factor = words[name]
    if _NUMBER.fullmatch(number) is None:
        raise NotationError(f'"{number}" in "{phrase}" is not a number', f'write a plain number, e.g. "{name} 5"')
    angle = abs(factor) == DEGREE
    most = MAX_CENTIMETRES if not angle else MAX_BODY_DEGREES if part == "body" else MAX_DEGREES
    if abs(float(number)) > most:
        unit = "degrees" if angle else "centimetres"
        raise NotationError(f'"{phrase}" is more than {most:g} {unit}', f"stay within {most:g} {unit}")
    return channel, factor * float(number)


def _suggest(word: str, words: Vocabulary) -> str:
    close = difflib.get_close_matches(word, list(words), n=1)
    hint = f'did you mean "{close[0]}"? ' if close else ""
    return hint + "words: " + ", ".join(sorted(words))
