"""Live partner response: dancers answer their leaders as the followers of recorded examples did (H024).

A leader's pose is read several times per beat and matched (`live/motion/partner_live`). The follower shows the answer
instead of the own steps, which continue unseen. The answer fades in and out over one measure. All decisions are made in
ticks; drawing only reads them.
"""

import contextlib
from dataclasses import replace
from typing import Final

import numpy as np

from live.base.arrays import Bool, Float32, Float64, Int32
from live.base.errors import PersonError
from live.motion.partner_live.hand_holds import LiveHandHolds
from live.motion.partner_live.stage_partner import ALL_STYLES, LeaderReader, style_key
from live.motion.pose.hand_hold import HeldArms
from live.show.dancers.variation import Variation
from live.show.group.casting import Casting
from live.show.partner.example_bank import ExampleBank, check_styles
from live.show.partner.leader_input import LeaderReaders, PoseSource, Tracks
from live.show.partner.partner_pairs import (
    Pair,
    PartnerSettings,
    build_pairs,
    check_pairs,
    leaders_first,
    partner_settings,
)
from live.show.partner.response_path import ResponsePath
from live.show.partner.response_pose import ResponsePoses, active_holds
from live.show.patch.patch import Patch
from live.show.selection.drawn_paths import DrawnPath

LIVE_STOP_S: Final = 0.25
"""Time [s] without motion after which a captured leader counts as stopped; until then followers hold their pose."""
STEP_STOP_BEATS: Final = 2.0
"""Beats without motion after which a leader who dances steps counts as stopped."""


class PartnerResponse:
    """The partners of one show with A dancers. Thread: the show's."""

    def __init__(self, patch: Patch, casting: Casting, variation: Variation, bank: ExampleBank | None) -> None:
        """Without a bank no dancer answers. Invalid partners were reported before (`check_partners`)."""
        count = len(casting.group)
        self.bank = bank or ExampleBank(())
        self._casting, self._variation = casting, variation
        self._beats = patch.clock.beats_per_measure
        self.settings: list[PartnerSettings] = partner_settings(patch) if self.bank.example_sets else []
        self.pairs: list[Pair] = []
        self.leaders = LeaderReaders(self.bank)
        """Readers of the leaders."""
        self.path = ResponsePath(count)
        """Fade and root motion of the followers."""
        self.streamed: Bool = np.zeros(count, np.bool_)
        """Dancers moved by a live stream, (A,): such a leader has stopped after HOLD."""
        self._poses = ResponsePoses(self.leaders, self.path)
        self.hand_holds = LiveHandHolds(count)
        """Hand holds between followers and leaders."""
        self._drawn_paths: dict[int, DrawnPath] = {}
        self._agents: Float32 = np.zeros((count, 2), np.float32)
        self._danced_beats: Float64 = np.zeros(count)
        self._patch_settings, self._roster = list(self.settings), casting.roster
        self._leaving: list[Pair] = []
        self.apply_settings(self.settings)

    def apply_patch(self, fresh: "PartnerResponse") -> None:
        """Adopt the partner tables of an edited patch; live settings stay for unchanged tables.

        Which examples there are does not change by that (`split_deferred` ensures that).
        """
        for index, (old, new) in enumerate(zip(self._patch_settings, fresh._patch_settings, strict=True)):
            if old != new:
                self.settings[index] = new
        self._patch_settings = fresh._patch_settings
        self.refresh_pairs()

    def facts(self) -> list[dict[str, object]]:
        """Return style and styles of each partner, and how much each example counts, where some count less than 1."""
        return [
            {
                "name": one.name,
                "style": one.style,
                "styles": [name for name in self.bank.example_sets[n].filters if name != ALL_STYLES],
                "weights": {name: value for name, value in self.bank.weights(n).items() if value < 1.0},
            }
            for n, one in enumerate(self.settings)
        ]

    # -- pairs ---------------------------------------------------------------------------------------------------

    def apply_settings(self, settings: list[PartnerSettings]) -> None:
        """Apply these settings; on PersonError nothing changes."""
        pairs = leaders_first(build_pairs(settings, self._casting))
        check_pairs(settings, pairs)
        check_styles(settings, self.bank)
        self.settings = settings
        self.leaders.set_examples(self.bank, [one.style for one in settings])
        self._set_pairs(pairs)

    def set_style(self, name: str, style: str) -> None:
        """Dance in a style of the examples, "" for all; raises PersonError if nobody called `name` has it.

        If `name` is all partners, those who do not have the style keep theirs.
        """
        found, wanted = self.find(name), style_key(style)
        having = [index for index in found if wanted in self.bank.example_sets[index].filters]
        if name.strip() not in ("", "*") or not having:
            having = found
        self.apply_settings([replace(one, style=wanted) if n in having else one for n, one in enumerate(self.settings)])

    def set_bank(self, bank: ExampleBank) -> list[str]:
        """Answer from other examples from now on; return what partners lose by it, in words.

        A style that they do not have any more is left for all. Raises ValueError if the examples do not fit.
        """
        lost = [one.style not in lore.filters for one, lore in zip(self.settings, bank.example_sets, strict=True)]
        told = [
            f"partner {one.name!r}: no example has the style {one.style!r} any more; all are danced"
            for one, gone in zip(self.settings, lost, strict=True)
            if gone
        ]
        settings = [
            replace(one, style=ALL_STYLES) if gone else one for one, gone in zip(self.settings, lost, strict=True)
        ]
        self.leaders.set_examples(bank, [one.style for one in settings])
        self.bank, self.settings = bank, settings
        return told

    def refresh_pairs(self) -> None:
        """Form the pairs again after groups changed; on an error the old pairs stay."""
        if self.settings:
            with contextlib.suppress(PersonError):
                self.apply_settings(self.settings)

    def find(self, name: str) -> list[int]:
        """Return the indices of the partners with this name; "" and "*" are all. Raises PersonError for none."""
        if name.strip() in ("", "*") and self.settings:
            return list(range(len(self.settings)))
        found = [n for n, one in enumerate(self.settings) if one.name.casefold() == name.casefold().strip()]
        if not found:
            known = ", ".join(one.name for one in self.settings) or "none: write [[partner]]"
            raise PersonError(f"no partner is called {name!r}", f"there are: {known}")
        return found

    def set_value(self, name: str, key: str, value: object) -> None:
        """Set one key of `PartnerSettings` for the partners called `name`; raises PersonError if the result is
        invalid."""
        asked = list(self.settings)
        for index in self.find(name):
            if key == "window":
                value = min(float(str(value)), self.bank.example_sets[index].stretch)
            asked[index] = replace(asked[index], **{key: value})  # type: ignore[arg-type]
        self.apply_settings(asked)

    def extend_path(self, name: str, point: tuple[float, float], *, restart: bool) -> None:
        """Extend the drawn path of the path-led partners called `name` to `point` [m]; PersonError for none."""
        meant = [index for index in self.find(name) if self.settings[index].by_path]
        if not meant:
            raise PersonError(f"partner {name!r} is led by dancers, not by a way", 'leader = "path" in the patch')
        for index in meant:
            rows = [pair.follower for pair in self.pairs if pair.partner == index]
            way = self._drawn_paths.get(index)
            if way is None or restart or way.rows != rows:
                way = self._drawn_paths[index] = DrawnPath(rows, self._agents)
            way.add(point)

    def _set_pairs(self, pairs: list[Pair]) -> None:
        """Read the leaders of these pairs; a follower with another leader fades out of the old answer first."""
        old = (*self._leaving, *self.pairs)
        self._leaving = [pair for pair in old if pair not in pairs and self.path.level[pair.follower] > 0.0]
        self.leaders.update(pairs, self._leaving)
        self.pairs = pairs

    # -- time ----------------------------------------------------------------------------------------------------

    def begin_measure(self) -> None:
        """Begin a measure: update the pairs if groups have changed."""
        if self._casting.roster is not self._roster:
            self._roster = self._casting.roster
            self.refresh_pairs()

    def danced_beats(self, phase: Float64) -> Float64:
        """Return the danced beat of each dancer at `phase` (A,) of the present measure."""
        return np.asarray((self._variation.measure + phase) * self._beats)

    def tick(
        self,
        phase: Float64,
        hips: Float32,
        hip_rotations: Float32,
        present: Bool,
        tracks: Tracks,
        poses_of: PoseSource,
        dt: float,
    ) -> None:
        """Advance by one tick of `dt` [s]: read the leaders and move the followers.

        Dancers are at `phase` (A,) of the measure with their `hips` (A, 2) [m] and hip rotation `hip_rotations` (A, 4);
        `present` (A,): present on the stage. `tracks`: positions (A, 2) [m] and velocities (A, 2) [m/s] of their
        agents. `poses_of` returns the present poses of some dancers.
        """
        if not self.settings:
            return
        danced = self.danced_beats(phase)
        passed = np.clip(danced - self._danced_beats, 0.0, 1.0)
        self._danced_beats[:] = danced
        self.leaders.read_due(self.settings, danced, present, tracks, poses_of)
        self.path.begin_tick()
        self._agents[:] = tracks[0]
        self._release_unused()
        for pair in self._active_pairs():
            one, read = self.settings[pair.partner], self.leaders.reader(pair)
            self.path.move_follower(
                pair, one, read, wanted=pair in self.pairs and self._should_answer(pair, one, read, present),
                danced_beats=danced[pair.leader], measures=float(passed[pair.follower]) / self._beats,
                hips=hips, agents=self._agents, dt=dt,
            )  # fmt: skip
            self.path.update_turn(pair.follower, hip_rotations[pair.follower], read.answer_rotation[0, 0])
        self._leaving = [pair for pair in self._leaving if self.path.level[pair.follower] > 0.0]
        self._poses.tick(self._active_pairs(), poses_of, dt)
        self.hand_holds.tick(
            active_holds(self._active_pairs(), self.settings, self.leaders, self.path.weight), poses_of, dt
        )
        for index, way in list(self._drawn_paths.items()):
            if not way.tick(tracks[0], self.path.seeking, self.path.goal, float(passed.max())):
                del self._drawn_paths[index]

    def _active_pairs(self) -> list[Pair]:
        """Return the pairs that may be shown: a follower still leaving one leader has no other yet."""
        busy = {pair.follower for pair in self._leaving}
        return [*(pair for pair in self.pairs if pair.follower not in busy), *self._leaving]

    def _release_unused(self) -> None:
        """Release the held state of leaders without a visible follower."""
        for key, read in self.leaders.readers.items():
            if read.held and not any(
                self.path.level[pair.follower] > 0.0
                for pair in self._active_pairs()
                if (pair.partner, pair.leader) == key
            ):
                read.release()
                for pair in self.pairs:
                    if (pair.partner, pair.leader) == key:
                        self.path.reset(pair.follower)

    def _should_answer(self, pair: Pair, one: PartnerSettings, read: LeaderReader, there: Bool) -> bool:
        """Whether the follower should answer: both are present, and the leader has not stopped."""
        if not (one.on and one.amount > 0.0 and read.answering and there[pair.leader] and there[pair.follower]):
            return False
        if one.by_path:
            return True  # a way may rest
        stands = LIVE_STOP_S / read.examples.period if self.streamed[pair.leader] else STEP_STOP_BEATS
        return read.still_frames <= stands * read.examples.per_beat

    # -- drawing -------------------------------------------------------------------------------------------------

    def lock_feet(self, position: Float32, rotation: Float32, age: float) -> None:
        """Apply foot lock to the answering dancers in world poses (A, J, 3) and (A, J, 4), `age` [s] after the last
        tick."""
        self._poses.lock_feet(position, rotation, age)

    def join_hands(self, position: Float32, rotation: Float32, age: float) -> None:
        """Join held hands in world poses (A, J, 3) and (A, J, 4), `age` [s] after the last tick."""
        self.hand_holds.apply(position, rotation, self.path.weight, age)

    def add_held_arms(self, held: HeldArms, age: float) -> None:
        """Add the arms that hold each other `age` [s] after the last tick, and the couples who dance as recorded."""
        for pair in self._active_pairs():
            if not pair.own_place and pair.leader != pair.follower and self.path.weight[pair.follower] > 0.0:
                held.partner[pair.follower] = pair.leader
                held.together[pair.follower] = self.path.weight[pair.follower]
        held.add_holds(*self.hand_holds.closed_holds(self.path.weight, age))

    def blend_poses(self, phase: Float64, position: Float32, rotation: Float32, rows: Int32 | None = None) -> None:
        """Blend the answers into world poses `position` (A, J, 3) and `rotation` (A, J, 4) of dancers at `phase`
        (A,) of the measure; with `rows` (n,) only of these dancers, (n, J, 3) and (n, J, 4)."""
        if self.pairs or self._leaving:
            self._poses.blend_poses(self._active_pairs(), self.danced_beats(phase), position, rotation, rows)
