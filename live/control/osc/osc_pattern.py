"""Matcher for OSC address patterns (`* ? [ ] { }`) without backtracking.

Each part of a pattern becomes a few bit-parallel automata (Baeza-Yates and Gonnet 1992, extended by `*`), so matching
time depends on the addresses and not on the pattern. As in OSC 1.0: `*` and `?` match within one part; `[a-z]`,
`[!ab]`, `{one,other}`.
"""

import re
from collections import OrderedDict
from collections.abc import Iterable
from typing import Final

MAX_CHARACTERS: Final = 96
MAX_CHOICES: Final = 8
"""Maximum number of rows to which the braces of one part may expand."""
CACHE_SIZE: Final = 64
"""Patterns whose addresses are cached."""
WILDCARDS: Final = frozenset("*?[]{}")
"""An address that contains one of them is a pattern."""

_PIECE = re.compile(r"\*+|\?|\[!?[^\[\]{},]+\]|[^*?\[\]{}]")
_BRACES = re.compile(r"\{([^{}\[\]]*)\}")
_NESTED = re.compile(r"\{[^}]*\{")


class BadPattern(ValueError):
    """The pattern is malformed, too long, or has too many choices."""


class _Row:
    """Automaton for one part of a pattern without braces."""

    def __init__(self, text: str) -> None:
        pieces = _PIECE.findall(text)
        if "".join(pieces) != text:
            raise BadPattern(text)
        self._star_mask = self._first = 0  # bit masks: places followed by a star; the start
        self._allowed: dict[str, int] = {}
        self._any = 0
        place = 0
        exclusions: list[tuple[int, str]] = []
        for piece in pieces:
            if piece[0] == "*":
                self._star_mask |= 1 << place
                continue
            place += 1
            bit = 1 << place
            if piece == "?":
                self._any |= bit
            elif piece[0] == "[":
                body = _expand_set(piece[1:-1].removeprefix("!"))
                if piece[1] == "!":
                    self._any |= bit
                    exclusions.append((bit, body))
                else:
                    for character in body:
                        self._allowed[character] = self._allowed.get(character, 0) | bit
            else:
                self._allowed[piece] = self._allowed.get(piece, 0) | bit
        self._excluded: dict[str, int] = {}
        for bit, body in exclusions:
            for character in body:
                self._excluded[character] = self._excluded.get(character, 0) | bit
        self._end = 1 << place

    def matches(self, part: str) -> bool:
        """Whether the row matches this part of an address."""
        at, stays, anything, takes, nots = 1, self._star_mask, self._any, self._allowed, self._excluded
        for character in part:
            allowed = takes.get(character, 0) | (anything & ~nots.get(character, 0))
            at = ((at << 1) & allowed) | (at & stays)
            if not at:
                return False
        return bool(at & self._end)


def _expand_set(body: str) -> str:
    """Return a character set with its ranges expanded (`a-d` to `abcd`); a dash at either end is literal."""
    spelled, position = [], 0
    while position < len(body):
        if position + 2 < len(body) and body[position + 1] == "-":
            low, high = ord(body[position]), ord(body[position + 2])
            spelled += [chr(code) for code in range(low, high + 1)]
            position += 3
        else:
            spelled.append(body[position])
            position += 1
    return "".join(spelled)


def _expand_braces(part: str) -> list[_Row]:
    """Return the rows of a part with its braces expanded."""
    if _NESTED.search(part):
        raise BadPattern(part)
    texts = [part]
    while (found := _BRACES.search(texts[0])) is not None:
        choices = found[1].split(",")
        if len(texts) * len(choices) > MAX_CHOICES:
            raise BadPattern(part)
        start, stop = found.span()
        # The text before the first braces is expanded already, so in every text they lie at the same distance from
        # the end.
        texts = [text[: len(text) - (len(texts[0]) - start)] + choice + text[len(text) - (len(texts[0]) - stop) :]
                 for text in texts for choice in choices]  # fmt: skip
    return [_Row(text) for text in texts]


class Matcher:
    """Finds the addresses that match a pattern. Use from one thread."""

    def __init__(self, addresses: Iterable[str]) -> None:
        self._tree: dict[str, dict[str, dict]] = {}  # type: ignore[type-arg]
        self._cache: OrderedDict[str, tuple[str, ...]] = OrderedDict()
        for address in addresses:
            branch = self._tree
            for part in address[1:].split("/"):
                branch = branch.setdefault(part, {})
            branch[""] = {}

    def is_cached(self, pattern: str) -> bool:
        """Whether the pattern is cached."""
        return pattern in self._cache

    def find(self, pattern: str) -> tuple[str, ...]:
        """Return the matching addresses in order; BadPattern if the pattern is malformed or too large."""
        found = self._cache.get(pattern)
        if found is None:
            if len(pattern) > MAX_CHARACTERS:
                raise BadPattern(pattern)
            parts = [_expand_braces(part) for part in pattern[1:].split("/")]
            found = tuple(_search(self._tree, parts, ""))
            self._cache[pattern] = found
            if len(self._cache) > CACHE_SIZE:
                self._cache.popitem(last=False)
        return found


def _search(branch: dict[str, dict], parts: list[list[_Row]], above: str) -> list[str]:  # type: ignore[type-arg]
    """Return the addresses below a branch that match the rest of a pattern."""
    if not parts:
        return [above] if "" in branch else []
    found: list[str] = []
    for part, below in branch.items():
        if part and any(row.matches(part) for row in parts[0]):
            found += _search(below, parts[1:], f"{above}/{part}")
    return found
