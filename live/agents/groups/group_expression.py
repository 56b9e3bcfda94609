"""Parser and evaluator of group expressions such as ``chorus & left - 1-4 + soloist`` (T104, T147; Schulz 2011, 4.3.3).

::

group = term { ("+" | "-") term }        union, difference; left associative
term  = atom { "&" atom }                intersection
atom  = 7 | 3-7 | word | "(" group ")"   a dancer, dancers from-to, a name, attribute or place
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from live.agents.groups.roster import ALL_WORDS, PLACE_WORDS, Mask, Roster
from live.base.errors import PersonError

MAX_LENGTH = 400
"""Largest length of an expression in characters; limits input from the network."""
MAX_DEPTH = 20
"""Largest nesting depth of brackets."""

_TOKEN = re.compile(r"\s*(?:(\d{1,6})-(\d{1,6})(?!\w)|(\d{1,6})(?!\w)|([^\W\d]\w*(?:-\w+)*)|([-+&()]))", re.UNICODE)


@dataclass(frozen=True, slots=True)
class NumberRange:
    """Dancers `first` to `last`, both included, counted from 1."""

    first: int
    last: int


@dataclass(frozen=True, slots=True)
class Word:
    """Name of a group, an attribute, a place, or everyone."""

    word: str


@dataclass(frozen=True, slots=True)
class BinaryOperation:
    """`left` united with (+), without (-) or intersected with (&) `right`."""

    sign: str
    left: "Expression"
    right: "Expression"


Expression = NumberRange | Word | BinaryOperation


class _Parser:
    def __init__(self, text: str) -> None:
        self._text = text
        self._tokens = self._split(text)
        self._next = 0

    def error(self, what: str) -> PersonError:
        return PersonError(
            f"group {self._text!r}: {what}",
            "write names, attributes, places or numbers (7, 3-7) joined by + (with), - (without) or & (both)",
        )

    def _split(self, text: str) -> list[tuple[str, str]]:
        tokens, at, text = [], 0, text.rstrip()
        while at < len(text):
            match = _TOKEN.match(text, at)
            if match is None:
                raise self.error(f"cannot be read from {text[at : at + 12].strip()!r} on")
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
        """Return and consume the next sign if it is one of `allowed`, else None."""
        if self._next < len(self._tokens):
            kind, text = self._tokens[self._next]
            if kind == "sign" and text in allowed:
                self._next += 1
                return text
        return None

    def group(self, depth: int = 0) -> Expression:
        result = self.term(depth)
        while (sign := self.sign("+-")) is not None:
            result = BinaryOperation(sign, result, self.term(depth))
        return result

    def term(self, depth: int) -> Expression:
        result = self.atom(depth)
        while self.sign("&") is not None:
            result = BinaryOperation("&", result, self.atom(depth))
        return result

    def atom(self, depth: int) -> Expression:
        if self.sign("(") is not None:
            if depth >= MAX_DEPTH:
                raise self.error(f"has more than {MAX_DEPTH} brackets within brackets")
            inner = self.group(depth + 1)
            if self.sign(")") is None:
                raise self.error("a bracket is not closed")
            return inner
        if self._next >= len(self._tokens):
            raise self.error("something is missing at the end" if self._tokens else "is empty")
        kind, text = self._tokens[self._next]
        self._next += 1
        if kind == "numbers":
            first, last = map(int, text.split("-"))
            if not 1 <= first <= last:
                raise self.error(f"dancers {text} do not exist: numbers count from 1, the smaller one first")
            return NumberRange(first, last)
        if kind == "word":
            return Word(text)
        raise self.error(f"{text!r} stands where a name or number is needed")

    def parse(self) -> Expression:
        result = self.group()
        if self._next < len(self._tokens):
            raise self.error(f"{self._tokens[self._next][1]!r} is one too many: join with +, - or &")
        return result


@lru_cache(maxsize=512)
def parse(text: str) -> Expression:
    """Parse an expression; PersonError names the part that cannot be parsed."""
    if len(text) > MAX_LENGTH:
        raise PersonError(f"a group of {len(text)} characters", f"at most {MAX_LENGTH}; name parts of it")
    return _Parser(text).parse()


Places = npt.NDArray[np.floating]


def select_dancers(
    expression: str,
    roster: Roster,
    positions: Places | None = None,
    half: tuple[float, float] = (6.0, 4.0),
) -> Mask:
    """Return the dancers that match `expression`, shape (A,).

    `positions` (A, 2) [m] is needed if the expression names places; `half` is half the stage's width and depth [m].
    Left is x < 0 and right the rest, back is z < 0 and front the rest, so halves cover all dancers; centre is the
    middle half in both directions. An empty expression means everyone. PersonError names a word that matches no dancer.
    """
    if not expression.strip():
        return np.ones(roster.count, np.bool_)
    whole = expression.strip()
    if whole in roster.known or roster.with_attribute(whole).any():  # a single name, which may contain blanks
        return roster.with_attribute(whole)
    return _evaluate(parse(expression), roster, positions, half, ())


def depends_on_positions(expression: str, roster: Roster) -> bool:
    """Whether the result depends on the dancers' positions."""
    if not expression.strip():
        return False
    return _depends_on_positions(parse(expression), roster, ())


def partition(
    parts: Sequence[str],
    roster: Roster,
    positions: Places | None = None,
    half: tuple[float, float] = (6.0, 4.0),
    within: Mask | None = None,
) -> list[Mask]:
    """Divide `within` (A,) into disjoint `parts`: one mask each; a dancer belongs to the first part that matches.

    One more mask holds the remaining dancers. To divide a part again, pass it as `within`.
    """
    left = np.ones(roster.count, np.bool_) if within is None else within.copy()
    masks: list[Mask] = []
    for part in parts:
        mask = left & select_dancers(part, roster, positions, half)
        masks.append(mask)
        left &= ~mask
    return [*masks, left]


def _evaluate(
    node: Expression, roster: Roster, positions: Places | None, half: tuple[float, float], enclosing: tuple[str, ...]
) -> Mask:
    if isinstance(node, BinaryOperation):
        left = _evaluate(node.left, roster, positions, half, enclosing)
        right = _evaluate(node.right, roster, positions, half, enclosing)
        return left | right if node.sign == "+" else left & right if node.sign == "&" else left & ~right
    if isinstance(node, NumberRange):
        if node.last > roster.count:
            raise PersonError(f"there is no dancer {node.last}", f"dancers are numbered 1 to {roster.count}")
        number = np.arange(1, roster.count + 1)
        return np.asarray((number >= node.first) & (number <= node.last))
    return _evaluate_word(node.word, roster, positions, half, enclosing)


def _evaluate_word(
    word: str, roster: Roster, positions: Places | None, half: tuple[float, float], enclosing: tuple[str, ...]
) -> Mask:
    if word in roster.groups:
        expression = _expression_of(word, roster, enclosing)
        return _evaluate(parse(expression), roster, positions, half, (*enclosing, word))
    mask = roster.with_attribute(word)
    if word in roster.known:
        return mask
    if not mask.any() and word.casefold() in ALL_WORDS:
        return np.ones(roster.count, np.bool_)
    if not mask.any() and word.casefold() in PLACE_WORDS:
        return _evaluate_place(word.casefold(), positions, half)
    if not mask.any():
        known = sorted({*roster.groups, *roster.words(), *PLACE_WORDS[:5], "all"})
        raise PersonError(f"no group and no dancer is called {word!r}", f"there are: {', '.join(known)}")
    return mask


def _expression_of(word: str, roster: Roster, enclosing: tuple[str, ...]) -> str:
    if word in enclosing:
        raise PersonError(f"group {word!r} contains itself: {' → '.join((*enclosing, word))}")
    return roster.groups[word]


def _evaluate_place(word: str, positions: Places | None, half: tuple[float, float]) -> Mask:
    if positions is None:
        raise PersonError(f"{word!r} means a place, and the dancers' positions are not known here")
    x, z = positions[:, 0], positions[:, 1]
    if word == "left":
        return np.asarray(x < 0.0)
    if word == "right":
        return np.asarray(x >= 0.0)
    if word == "back":
        return np.asarray(z < 0.0)
    if word == "front":
        return np.asarray(z >= 0.0)
    return np.asarray((np.abs(x) <= half[0] / 2.0) & (np.abs(z) <= half[1] / 2.0))


def _depends_on_positions(node: Expression, roster: Roster, enclosing: tuple[str, ...]) -> bool:
    if isinstance(node, BinaryOperation):
        return _depends_on_positions(node.left, roster, enclosing) or _depends_on_positions(
            node.right, roster, enclosing
        )
    if isinstance(node, NumberRange):
        return False
    if node.word.casefold() in PLACE_WORDS and node.word not in roster.groups and node.word not in roster.known:
        return not roster.with_attribute(node.word).any()
    if node.word in roster.groups:
        return _depends_on_positions(
            parse(_expression_of(node.word, roster, enclosing)), roster, (*enclosing, node.word)
        )
    return False
