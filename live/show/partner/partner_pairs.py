"""Leader and follower pairs from `[[partner]]` tables and controls, with their checks."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.errors import PersonError, error_context
from live.motion.partner_live.stage_partner import ALL_STYLES, style_key
from live.show.group.casting import Casting
from live.show.patch.patch import Patch

NOBODY: Final = -1
MAX_LEADERS: Final = 4
"""Maximum number of leaders read at once; each needs its own search."""
MAX_PATH_FOLLOWERS: Final = 8
"""Maximum number of followers led by a path, which is faster to read."""


@dataclass(frozen=True, slots=True)
class PartnerSettings:
    """Settings of one partner."""

    name: str
    leader: str
    """Words that select the leader; `path`: each follower's own path leads."""
    follower: str
    on: bool = True
    amount: float = 1.0
    window: float = 0.04
    """How far units may begin off the beat [s]."""
    place: str | None = None
    hands: float = 1.0
    """Weight of holding hands where the examples do."""
    style: str = ALL_STYLES
    """Style of the examples that is danced, as `style_key` writes it."""

    @property
    def by_path(self) -> bool:
        """Whether each follower is led by the path of the follower's own agent."""
        return self.leader.strip().casefold() == "path"


@dataclass(frozen=True, slots=True)
class Pair:
    """One answering dancer."""

    partner: int
    """Index of the `[[partner]]`."""
    leader: int
    """Row of the leader; the follower's own row if a path leads."""
    follower: int
    own_place: bool


def partner_settings(patch: Patch) -> list[PartnerSettings]:
    """Return the partner settings of a patch."""
    return [
        PartnerSettings(
            one.name,
            one.leader,
            one.follower,
            one.on,
            one.amount,
            min(one.window, one.stretch),
            one.place,
            one.hands,
            style_key(one.style or ALL_STYLES),
        )
        for one in patch.partner
    ]


def check_partners(patch: Patch, casting: Casting) -> None:
    """Raise PersonError, with the patch keys, for invalid partners of a patch."""
    asked = partner_settings(patch)
    for index, one in enumerate(asked):
        try:
            build_partner_pairs(index, one, casting)
        except PersonError as error:
            raise PersonError(
                f"partner {one.name!r}: {error.message}", error.remedy, ("partner", index, *error.key_path)
            ) from None
        hand_in_hand = [patch.group[casting.group[pair.follower]] for pair in build_partner_pairs(index, one, casting)]
        for group in hand_in_hand:
            if group.partners is not None:
                raise PersonError(
                    f"partner {one.name!r}: the follower is in {group.name!r}, whose dancers hold hands",
                    f"take partners out of the group {group.name!r}, or name another follower",
                    ("partner", index, "follower"),
                )
    pairs = build_pairs(asked, casting)
    with error_context("partner", ("partner",)):
        check_pairs(asked, pairs)


def build_pairs(settings: Sequence[PartnerSettings], casting: Casting) -> list[Pair]:
    """Return all pairs; raises PersonError for words that select no dancer, and for counts that do not match."""
    return [pair for index, one in enumerate(settings) for pair in build_partner_pairs(index, one, casting)]


def build_partner_pairs(index: int, one: PartnerSettings, casting: Casting) -> list[Pair]:
    """Return the pairs of one partner; `place` of a PersonError is the wrong key."""
    followers = _select(one.follower, casting, "follower")
    if one.by_path:
        return [Pair(index, row, row, True) for row in followers]
    leaders = _select(one.leader, casting, "leader")
    both = sorted(set(leaders) & set(followers))
    if both:
        raise PersonError(
            f"dancer {both[0] + 1} would answer themselves: they are in both {one.leader!r} and {one.follower!r}",
            "name other dancers for one of them",
            ("leader",),
        )
    if len(leaders) not in (1, len(followers)):
        raise PersonError(
            f"{len(leaders)} lead and {len(followers)} answer", "as many of each, or a single leader", ("follower",)
        )
    alone = len(leaders) == 1 and len(followers) > 1
    own = one.place == "own" or (one.place is None and alone)
    if alone:
        leaders = leaders * len(followers)
    return [Pair(index, lead, follow, own) for lead, follow in zip(leaders, followers, strict=True)]


def _select(words: str, casting: Casting, key: str) -> list[int]:
    with error_context(f"{key} {words[:80]!r}", (key,)):
        if casting.depends_on_places(words):
            raise PersonError("places select other dancers from moment to moment", "name groups, attributes or numbers")
        rows = np.flatnonzero(casting.select(words, np.zeros((len(casting.group), 2)))).tolist()
        if not rows:
            raise PersonError("no dancer is selected", "name a group, attributes or numbers of dancers")
        return [int(row) for row in rows]


def check_pairs(settings: Sequence[PartnerSettings], pairs: Sequence[Pair]) -> None:
    """Raise PersonError for a dancer who answers two leaders, for cycles, and for too many leaders."""
    answers: dict[int, Pair] = {}
    for pair in pairs:
        before = answers.setdefault(pair.follower, pair)
        if before is not pair:
            names = settings[before.partner].name, settings[pair.partner].name
            raise PersonError(
                f"dancer {pair.follower + 1} answers in {names[0]!r} and in {names[1]!r}",
                "name the dancer in only one of them",
                (pair.partner, "follower"),
            )  # fmt: skip
    for pair in pairs:
        way = [pair.follower]
        while way[-1] in answers and answers[way[-1]].leader != answers[way[-1]].follower:
            way.append(answers[way[-1]].leader)
            if way[-1] == way[0]:
                told = " answers ".join(str(row + 1) for row in way)
                raise PersonError(
                    f"a circle of dancers: {told}; one of them has to lead",
                    "take one of these partners out",
                    (pair.partner, "leader"),
                )
            if len(way) > len(answers) + 1:
                break
    leaders = {(pair.partner, pair.leader) for pair in pairs if pair.leader != pair.follower}
    if len(leaders) > MAX_LEADERS:
        raise PersonError(
            f"{len(leaders)} leaders are answered; {MAX_LEADERS} at most", "let several dancers answer one leader"
        )
    walkers = sum(pair.leader == pair.follower for pair in pairs)
    if walkers > MAX_PATH_FOLLOWERS:
        raise PersonError(
            f"{walkers} followers are led by a path; {MAX_PATH_FOLLOWERS} at most", "name fewer followers"
        )


def leaders_first(pairs: Sequence[Pair]) -> list[Pair]:
    """Return the pairs with leaders before the dancers who answer them (there are no cycles)."""
    answers = {pair.follower: pair for pair in pairs if pair.leader != pair.follower}

    def depth(pair: Pair) -> int:
        found, row = 0, pair.leader
        while row in answers and found <= len(answers):
            found, row = found + 1, answers[row].leader
        return found

    return sorted(pairs, key=lambda pair: (depth(pair), pair.partner, pair.follower))
