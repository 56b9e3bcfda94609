"""Light that follows the score: soloists are lit, groups are told apart, and the piece's form is seen.

It is a layer over the picture's row, so no parameter changes by itself: what a cue, a scene, a look or a hand has set
(`Parameters.claimed`) it leaves alone. `/dance/light/score` is its amount. It only fades, over a beat or more, except
on a drop, which comes at most once in sixteen beats; so it never comes near the limit on flashes.

| what happens | what is seen |
|---|---|
| before the first downbeat | half light; it fades up within a measure |
| the last measure of a score that ends, and after it | fades to half, then to black |
| a soloist, or a dancer alone | a follow spot, and a little less light on the others |
| a group rests while others dance | its colours are darker, theirs brighter |
| several groups | their colours from the sides |
| quiet and loud music | lower and cooler, higher |
| a build-up, a drop | beams rise and cross, then open wide |
"""

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from live.base.arrays import Float64, Int64
from live.base.parameter import SPOT_COUNT
from live.base.picture_parameters import BY_ADDRESS, COLOURS_START, PART_COUNT
from live.base.scalar_kernels import damper
from live.base.stage_snapshot import StageView
from live.clock.ticks import TICK
from live.show.desk.camera_kernels import spring
from live.show.score.playhead import END

if TYPE_CHECKING:
    from live.show.desk.camera_subjects import Subjects
    from live.show.desk.parameters import Parameters
    from live.show.group.division import Division
    from live.show.score.score_runner import ScoreRunner

SOLO_SPOTS: Final = 2
"""The last follow spots, which it takes for soloists while nobody else uses them."""
PRESET: Final = 0.35
"""Share of the light before the first downbeat."""
ENDING: Final = 0.5
"""Share of the light at the end of the last measure."""
UP_BEATS, DOWN_BEATS = 4.0, 8.0
"""Beats in which the light goes from dark to full, and from full to dark."""
ENERGY_HALFLIFE_BEATS: Final = 4.0
GROUP_HALFLIFE_BEATS: Final = 2.0
DROP_HALFLIFE_BEATS: Final = 2.0
DROP_ATTACK_BEATS: Final = 0.25
SPOT_BEATS: Final = 2.0
"""Beats in which a follow spot fades in or out."""
SPOT_STIFFNESS: Final = 5.0
"""How closely a spot follows its dancer [1/s]."""
SPOT_STRENGTH: Final = 0.9
TOGETHER: Final = 0.5
"""Share of it on a soloist who dances what their group dances."""
REST: Final = 0.6
"""A group that moves less than this share of the most active one rests."""
ACTIVITY_SHARE: Final = 0.4
"""How much of a group's activity is that of its present measure; the rest is that of the measures before."""
DARKER, BRIGHTER = 0.55, 1.12
"""Factors of the colours of groups that rest while others dance, and of those others."""
LOUD_RANGE: Final = 0.5
"""How much brighter the loudest music is than the quietest, as a share of the light."""
COOL: Final = np.array([0.74, 0.86, 1.12])
"""Factor of the key light's colour in the quietest music."""
SOLO_DIM: Final = 0.25
"""How much of the key light is taken away while a soloist is lit."""
SIDES: Final = 0.3
"""Strength of the groups' colours from the sides."""
STEPS: Final = 48.0
"""Floor and wall are drawn anew if the key light changes: it goes in so many steps."""

LEVEL, KEY, RIM = (BY_ADDRESS[f"/dance/light/{name}"].first for name in ("level", "key", "rim"))
KEY_COLOUR: Final = BY_ADDRESS["/dance/light/key/colour"].row_slice
BEAMS, FAN = BY_ADDRESS["/dance/light/beams"].first, BY_ADDRESS["/dance/light/beams/fan"].first
SIDE: Final = BY_ADDRESS["/dance/light/side"].first
LEFT, RIGHT = (BY_ADDRESS[f"/dance/light/side/{name}"].row_slice for name in ("left", "right"))
ENERGY: Final = BY_ADDRESS["/dance/light/energy"].first
AMOUNT: Final = BY_ADDRESS["/dance/light/score"].first
SPOTS: Final = tuple(BY_ADDRESS[f"/dance/spot/{number}"].first for number in range(1, SPOT_COUNT + 1))


class ScoreLight:
    """The layer of one show. Call `tick` for every tick, `show` for every picture. Thread: the show's."""

    def __init__(
        self, parameters: "Parameters", subjects: "Subjects", score_runner: "ScoreRunner", division: "Division"
    ) -> None:
        self._parameters, self._subjects, self._score_runner = parameters, subjects, score_runner
        self._division = division
        self.suspended = False
        """Whether a panic has switched it off, until the show goes on."""
        self._house = PRESET
        self._energy, self._build = 0.5, 0.0
        self._drop, self._drop_goal, self._drops = 0.0, 0.0, 0
        self._group: Float64 = np.ones(division.group_count)  # light of each group
        self._group_goal: Float64 = np.ones(division.group_count)
        self._activity: Float64 = np.zeros(division.group_count)  # smoothed over measures; 0: not there
        self._sides = np.zeros(2)  # weight of the wash now, and where it goes
        self._side_group: Int64 = np.zeros(2, np.int64)  # groups on the left and on the right
        self._dancer: Int64 = np.full(SOLO_SPOTS, -1, np.int64)
        self._wanted: Int64 = np.full(SOLO_SPOTS, -1, np.int64)
        self._wanted_level = np.zeros(SOLO_SPOTS)
        self._spot = np.zeros(SOLO_SPOTS)
        self._place, self._speed = np.zeros((SOLO_SPOTS, 2)), np.zeros((SOLO_SPOTS, 2))
        self._planned = False  # whether the present measure was looked at

    def begin_measure(self) -> None:
        """Look at the dancers again: another measure begins."""
        self._planned = False

    def tick(self, tempo: float, ticks: int = 1) -> None:
        """Advance by `ticks` at a tempo [bpm]."""
        seconds = ticks * TICK
        beats = seconds * tempo / 60.0
        if not self._planned:
            self._plan()
        self._follow_form(beats)
        self._follow_music(beats)
        damp = 0.5 ** (beats / GROUP_HALFLIFE_BEATS)
        self._group += (self._group_goal - self._group) * (1.0 - damp)
        self._sides[0] = damper(self._sides[0], self._sides[1], 2.0, beats)
        self._follow_soloists(seconds, beats)

    # -- what to show ------------------------------------------------------------------------------------------------

    def _plan(self) -> None:
        """Decide for this measure who is a soloist and which groups lead."""
        self._planned = True
        subjects = self._subjects
        present = subjects.present()
        soloists = subjects.soloists(present, spots=False)
        activity = subjects.activity(present)
        self._plan_groups(present, activity)
        rows = np.flatnonzero(soloists)[:SOLO_SPOTS].tolist()
        kept = [int(dancer) for dancer in self._wanted.tolist() if dancer in rows]
        rest = [dancer for dancer in rows if dancer not in kept]
        for spot in range(SOLO_SPOTS):
            now = int(self._wanted[spot])
            self._wanted[spot] = now if now in kept else (rest.pop(0) if rest else -1)
            dancer = int(self._wanted[spot])
            if dancer >= 0:
                alone = subjects.dances_alone(dancer, present)
                self._wanted_level[spot] = SPOT_STRENGTH * (1.0 if alone else TOGETHER)

    def _plan_groups(self, present: Any, activity: Float64) -> None:
        group, place = self._division.group_of[self._division.part], self._subjects.places()
        there = np.unique(group[present])
        there = there[(there >= 0) & (there < len(self._group))]
        self._group_goal[:], self._sides[1] = 1.0, 0.0
        means = np.array([activity[present & (group == one)].mean() for one in there])
        before = self._activity[there]
        self._activity[:] = 0.0
        self._activity[there] = means = np.where(before > 0.0, before + ACTIVITY_SHARE * (means - before), means)
        if len(there) < 2:
            return
        most = float(means.max())
        if most > 0.0 and float(means.min()) < REST * most:
            self._group_goal[there] = np.where(means < REST * most, DARKER, BRIGHTER)
        across = [float(place[present & (group == one), 0].mean()) for one in there]
        self._side_group[:] = there[int(np.argmin(across))], there[int(np.argmax(across))]
        self._sides[1] = 1.0

    # -- time ----------------------------------------------------------------------------------------------------------

    def _follow_form(self, beats: float) -> None:
        """Fade up at the beginning and out at the end of the piece."""
        playhead = self._score_runner.playhead
        measure = playhead.measure
        goal = 1.0
        if measure < 0:
            goal = PRESET
        elif playhead.place(measure).section == END:
            goal = 0.0
        elif playhead.ahead(measure + 1).section == END:
            goal = ENDING
        way = goal - self._house
        self._house += max(-beats / DOWN_BEATS, min(way, beats / UP_BEATS))

    def _follow_music(self, beats: float) -> None:
        mood, drops = self._score_runner.mood, self._score_runner.drops
        heard = mood.value("energy") if mood.heard else 0.5
        self._energy = damper(self._energy, heard, ENERGY_HALFLIFE_BEATS, beats)
        self._build = damper(self._build, mood.value("build"), 0.5, beats)
        if drops != self._drops:
            self._drops, self._drop_goal = drops, 1.0
        self._drop_goal = damper(self._drop_goal, 0.0, DROP_HALFLIFE_BEATS, beats)
        self._drop = damper(self._drop, self._drop_goal, DROP_ATTACK_BEATS, beats)

    def _follow_soloists(self, seconds: float, beats: float) -> None:
        if int(self._wanted.max()) < 0 and not self._spot.any():
            return
        places = self._subjects.places()
        for spot in range(SOLO_SPOTS):
            wanted, dancer = int(self._wanted[spot]), int(self._dancer[spot])
            if dancer != wanted and self._spot[spot] <= 0.0:
                self._dancer[spot] = dancer = wanted
                if wanted >= 0:
                    self._place[spot], self._speed[spot] = places[wanted], 0.0
            goal = float(self._wanted_level[spot]) if dancer == wanted >= 0 else 0.0
            way = goal - float(self._spot[spot])
            self._spot[spot] += math.copysign(min(abs(way), beats / SPOT_BEATS), way)
            if dancer >= 0:
                spring(self._place[spot], self._speed[spot], places[dancer], SPOT_STIFFNESS, seconds)

    # -- pictures ------------------------------------------------------------------------------------------------------

    @property
    def _claimed(self) -> Any:
        return self._parameters.claimed

    def show(self, view: StageView, seconds: float) -> None:
        """Lay the light over a picture's row, this long after the last tick."""
        row = view.picture
        if row is None or self.suspended or row[AMOUNT] <= 0.0:
            return
        amount, claimed = float(row[AMOUNT]), self._claimed
        lit, build = self._show_spots(view, row, amount, seconds), self._build * (1.0 - self._drop)
        if not claimed[LEVEL]:
            loud = LOUD_RANGE * (self._energy - 0.5) if row[ENERGY] <= 0.0 else 0.0
            row[LEVEL] *= (1.0 - amount * (1.0 - self._house)) * (1.0 + amount * (loud + 0.2 * self._drop))
        if not claimed[KEY]:
            row[KEY] *= _in_steps(1.0 - amount * (SOLO_DIM * lit + 0.3 * build))
        if not claimed[KEY_COLOUR].any():
            cool = _in_steps(amount * max(0.45 - self._energy, 0.0) / 0.45)
            row[KEY_COLOUR] *= 1.0 + (COOL - 1.0) * cool
        if not claimed[RIM]:
            row[RIM] *= _in_steps(1.0 + amount * 0.5 * build)
        if not claimed[BEAMS]:
            row[BEAMS] += amount * (0.9 * build + 0.8 * self._drop)
        if not claimed[FAN]:
            row[FAN] += amount * (self._drop - 0.7 * build)
        self._show_groups(row, amount)

    def _show_spots(self, view: StageView, row: Float64, amount: float, seconds: float) -> float:
        """Light the soloists with the spots that nobody uses; return how much the first one is lit, 0 to 1."""
        most = 0.0
        for spot in range(SOLO_SPOTS):
            number = SPOT_COUNT - 1 - spot
            at = SPOTS[number]
            if self._spot[spot] <= 0.0 or row[at] > 0.0 or self._claimed[at]:
                continue
            row[at] = amount * self._spot[spot]
            view.spot[number] = self._place[spot] + self._speed[spot] * seconds
            most = max(most, amount * float(self._spot[spot]) / SPOT_STRENGTH)
        return most

    def _show_groups(self, row: Float64, amount: float) -> None:
        """Tell the groups apart: by the light on their colours, and by their colours from the sides."""
        claimed = self._claimed
        colours = row[COLOURS_START : COLOURS_START + 3 * PART_COUNT].reshape(PART_COUNT, 3)
        sides = amount * SIDES * float(self._sides[0])
        if sides > 0.0 and not claimed[SIDE] and row[SIDE] <= 0.0:
            row[SIDE] = sides
            for group, where in zip(self._side_group.tolist(), (LEFT, RIGHT), strict=True):
                if not claimed[where].any():
                    row[where] = colours[group]
        for part in range(PART_COUNT if self._division.is_divided else len(self._group)):
            group = int(self._division.group_of[part])
            first = COLOURS_START + 3 * part
            if 0 <= group < len(self._group) and not claimed[first]:
                colours[part] = np.minimum(colours[part] * (1.0 + amount * (self._group[group] - 1.0)), 1.0)

    # -- reports -------------------------------------------------------------------------------------------------------

    def hashed(self) -> tuple[Float64, ...]:
        """Return the arrays that belong to the state hash; none while it is off."""
        if self._parameters.picture[AMOUNT] <= 0.0:
            return ()
        numbers = np.array([self._house, self._energy, self._build, self._drop, float(self.suspended)])
        return (numbers, self._group, self._spot, self._place)

    def facts(self) -> dict[str, Any]:
        """Return whom it lights and how bright it is, for the status."""
        solo = [int(one) + 1 for one, lit in zip(self._dancer, self._spot, strict=True) if lit > 0.0]
        return {"score_light": {"on": not self.suspended, "house": round(self._house, 3), "soloists": solo}}


def _in_steps(number: float) -> float:
    return round(number * STEPS) / STEPS
