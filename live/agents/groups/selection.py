"""Selection: an expression, the dancers and where they stand now → who is meant (T104, Schulz 2011, 4.3.3)."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from live.agents.groups.expression import Combined, Expression, Numbers, parse
from live.agents.groups.roster import ALL_WORDS, PLACE_WORDS, Mask, Roster
from live.base.errors import PersonError

Places = npt.NDArray[np.floating]


def selection(
    expression: str,
    roster: Roster,
    positions: Places | None = None,
    half: tuple[float, float] = (6.0, 4.0),
) -> Mask:
    """Who is meant by `expression`, shape (A,).

    `positions` (A, 2) [m] is needed where the expression names places; `half` is half the stage's width and depth
    [m]. Left is x < 0 and right the rest, back is z < 0 and front the rest, so halves cover everybody; centre is the
    middle half both ways. An empty expression means everyone. A PersonError says what nobody is.
    """
    if not expression.strip():
        return np.ones(roster.count, np.bool_)
    whole = expression.strip()
    if whole in roster.known or roster.having(whole).any():  # it is one name, which may hold blanks
        return roster.having(whole)
    return _evaluate(parse(expression), roster, positions, half, ())


def needs_places(expression: str, roster: Roster) -> bool:
    """Whether who is meant depends on where the dancers stand."""
    if not expression.strip():
        return False
    return _names_places(parse(expression), roster, ())


def divide(
    parts: Sequence[str],
    roster: Roster,
    positions: Places | None = None,
    half: tuple[float, float] = (6.0, 4.0),
    within: Mask | None = None,
) -> list[Mask]:
    """Divide `within` (A,) into `parts`: one mask for each, nobody in two (the first part that means her counts).

    One mask more holds who is left over. Dividing a part again is calling this with the part as `within`.
    """
    left = np.ones(roster.count, np.bool_) if within is None else within.copy()
    masks: list[Mask] = []
    for part in parts:
        mask = left & selection(part, roster, positions, half)
        masks.append(mask)
        left &= ~mask
    return [*masks, left]


def _evaluate(
    node: Expression, roster: Roster, positions: Places | None, half: tuple[float, float], inside: tuple[str, ...]
) -> Mask:
    if isinstance(node, Combined):
        left = _evaluate(node.left, roster, positions, half, inside)
        right = _evaluate(node.right, roster, positions, half, inside)
        return left | right if node.sign == "+" else left & right if node.sign == "&" else left & ~right
    if isinstance(node, Numbers):
        if node.last > roster.count:
            raise PersonError(f"there is no dancer {node.last}", f"dancers are numbered 1 to {roster.count}")
        number = np.arange(1, roster.count + 1)
        return np.asarray((number >= node.first) & (number <= node.last))
    return _named(node.word, roster, positions, half, inside)


def _named(
    word: str, roster: Roster, positions: Places | None, half: tuple[float, float], inside: tuple[str, ...]
) -> Mask:
    if word in roster.groups:
        expression = _expression_of(word, roster, inside)
        return _evaluate(parse(expression), roster, positions, half, (*inside, word))
    mask = roster.having(word)
    if word in roster.known:
        return mask
    if not mask.any() and word.casefold() in ALL_WORDS:
        return np.ones(roster.count, np.bool_)
    if not mask.any() and word.casefold() in PLACE_WORDS:
        return _placed(word.casefold(), positions, half)
    if not mask.any():
        known = sorted({*roster.groups, *roster.words(), *PLACE_WORDS[:5], "all"})
        raise PersonError(f"no group and no dancer is called {word!r}", f"there are: {', '.join(known)}")
    return mask


def _expression_of(word: str, roster: Roster, inside: tuple[str, ...]) -> str:
    if word in inside:
        raise PersonError(f"group {word!r} contains itself: {' → '.join((*inside, word))}")
    return roster.groups[word]


def _placed(word: str, positions: Places | None, half: tuple[float, float]) -> Mask:
    if positions is None:
        raise PersonError(f"{word!r} means a place, and where the dancers stand is not known here")
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


def _names_places(node: Expression, roster: Roster, inside: tuple[str, ...]) -> bool:
    if isinstance(node, Combined):
        return _names_places(node.left, roster, inside) or _names_places(node.right, roster, inside)
    if isinstance(node, Numbers):
        return False
    if node.word.casefold() in PLACE_WORDS and node.word not in roster.groups and node.word not in roster.known:
        return not roster.having(node.word).any()
    if node.word in roster.groups:
        return _names_places(parse(_expression_of(node.word, roster, inside)), roster, (*inside, node.word))
    return False
