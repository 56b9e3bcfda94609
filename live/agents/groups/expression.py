"""The little language of groups: ``chorus & left - 1-4 + soloist`` becomes a tree (T104, T147).

::

    group = term { ("+" | "-") term }        with, without; from left to right
    term  = atom { "&" atom }                who is both
    atom  = 7 | 3-7 | word | "(" group ")"   a dancer, dancers from-to, a name, attribute or place
"""

import re
from dataclasses import dataclass
from functools import lru_cache

from live.base.errors import PersonError

LONGEST = 400
"""Characters an expression may have; what comes from the network is bounded by it."""
DEEPEST = 20
"""Brackets within brackets."""

_TOKEN = re.compile(r"\s*(?:(\d{1,6})-(\d{1,6})(?!\w)|(\d{1,6})(?!\w)|([^\W\d]\w*(?:-\w+)*)|([-+&()]))", re.UNICODE)


@dataclass(frozen=True, slots=True)
class Numbers:
    """Dancers `first` to `last`, both included, counted from 1."""

    first: int
    last: int


@dataclass(frozen=True, slots=True)
class Word:
    """A group's name, an attribute, a place, or everyone."""

    word: str


@dataclass(frozen=True, slots=True)
class Combined:
    """`left` with (+), without (-) or at the same time (&) `right`."""

    sign: str
    left: "Expression"
    right: "Expression"


Expression = Numbers | Word | Combined


class _Reader:
    def __init__(self, text: str) -> None:
        self._text = text
        self._tokens = self._split(text)
        self._next = 0

    def wrong(self, what: str) -> PersonError:
        return PersonError(
            f"group {self._text!r}: {what}",
            "write names, attributes, places or numbers (7, 3-7) joined by + (with), - (without) or & (both)",
        )

    def _split(self, text: str) -> list[tuple[str, str]]:
        tokens, at, text = [], 0, text.rstrip()
        while at < len(text):
            match = _TOKEN.match(text, at)
            if match is None:
                raise self.wrong(f"cannot be read from {text[at : at + 12].strip()!r} on")
            first, last, number, word, sign = match.groups()
            if first is not None:
                tokens.append(("numbers", f"{first}-{last}"))
            elif number is not None:
                tokens.append(("numbers", f"{number}-{number}"))
            elif word is not None:
                tokens.append(("word", word))
            else:
                tokens.append(("sign", sign))
            at = match.end()
        return tokens

    def sign(self, allowed: str) -> str | None:
        """The next sign if it is one of `allowed`; then it is taken."""
        if self._next < len(self._tokens):
            kind, text = self._tokens[self._next]
            if kind == "sign" and text in allowed:
                self._next += 1
                return text
        return None

    def group(self, depth: int = 0) -> Expression:
        result = self.term(depth)
        while (sign := self.sign("+-")) is not None:
            result = Combined(sign, result, self.term(depth))
        return result

    def term(self, depth: int) -> Expression:
        result = self.atom(depth)
        while self.sign("&") is not None:
            result = Combined("&", result, self.atom(depth))
        return result

    def atom(self, depth: int) -> Expression:
        if self.sign("(") is not None:
            if depth >= DEEPEST:
                raise self.wrong(f"has more than {DEEPEST} brackets within brackets")
            inner = self.group(depth + 1)
            if self.sign(")") is None:
                raise self.wrong("a bracket is not closed")
            return inner
        if self._next >= len(self._tokens):
            raise self.wrong("something is missing at the end" if self._tokens else "says nothing")
        kind, text = self._tokens[self._next]
        self._next += 1
        if kind == "numbers":
            first, last = map(int, text.split("-"))
            if not 1 <= first <= last:
                raise self.wrong(f"dancers {text} do not exist: numbers count from 1, the smaller one first")
            return Numbers(first, last)
        if kind == "word":
            return Word(text)
        raise self.wrong(f"{text!r} stands where a name or number is needed")

    def whole(self) -> Expression:
        result = self.group()
        if self._next < len(self._tokens):
            raise self.wrong(f"{self._tokens[self._next][1]!r} is one too many: join with +, - or &")
        return result


@lru_cache(maxsize=512)
def parse(text: str) -> Expression:
    """Read an expression; PersonError says what cannot be read."""
    if len(text) > LONGEST:
        raise PersonError(f"a group of {len(text)} characters", f"at most {LONGEST}; name parts of it")
    return _Reader(text).whole()
