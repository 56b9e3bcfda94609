"""Live texturing: replaces upper bodies by recorded ones, matched by leg motion without look-ahead (P024).

In every beat each dancer's leg motion, from half a beat before the beat line to a quarter after it, is compared with
the beats of the patch's `[texture]` recordings. The upper body of the best match fades in within half a beat. If the
best match continues the present recording, nothing changes. What the legs of the last beat tell of upper bodies at
other choreographies turns the joints besides (`live_prediction`). Choices are made in ticks; drawing only reads them.
"""

import math
from typing import Final

import numpy as np

from live.base.arrays import Float32, Float64, Int32, Int64
from live.base.motion_parameters import HEAD, TEXTURE
from live.motion.skeleton import SKELETON
from live.motion.texture.live_bank import TextureBank
from live.motion.texture.live_texture_kernels import (
    DIMENSIONS,
    FEATURES,
    NEVER,
    PER_BEAT,
    UPPER_COUNT,
    blend_upper_bodies,
    follow_legs,
    measure_legs,
    nearest_fragment,
    record_moments,
    signs_of,
    write_prefix,
)
from live.show.dancers.variation import Variation

PREFIX: Final = 0.25
"""Part of a beat whose leg motion is used before the beat is matched [beats]."""
BLEND: Final = 0.5
"""Duration of a blend from one fragment to another [beats]."""
SWITCH_COST: Final = 0.5
"""Cost of leaving a recording that continues, as a share of the mean distance between beats."""
DISTANCE_JITTER: Final = 0.6
"""Random weighting of distances per dancer, 0 for none, so that dancers with the same steps choose differently."""
FADE_HALFLIFE: Final = 0.15
"""Half-life [s] of the fade towards the fader's value: fast fader moves cause no pop."""
CHOICE_TICKS: Final = 10
"""Choices are spread over this many ticks: all at once would overload one tick."""
FULL_TEXTURE: Final = 0.99
"""With more texture than this, the step's own upper body is invisible."""
_MOMENTS: Final = 16
_EIGHTHS: Final = 8


class LiveTexture:
    """Texture state of the upper bodies of A dancers."""

    def __init__(self, bank: TextureBank, variation: Variation, count: int, *, seed: int, beats: int) -> None:
        """`bank` may be empty; `variation[TEXTURE]` (A,) holds the faders' values; `beats` of a measure."""
        self.bank = bank
        self._variation = variation
        variation.has_recordings = bank.count > 0
        self._seed, self._beats = seed, beats
        self.level: Float32 = np.zeros(count, np.float32)
        """Present texture weight, 0 to 1, (A,)."""
        self.fragment: Int32 = np.full(count, -1, np.int32)
        """Beat of the recordings chosen last, -1 before the first, (A,)."""
        self.chosen_beat: Int64 = np.full(count, NEVER, np.int64)
        """The danced beat for which it was chosen, (A,)."""
        self.switch_beat: Float64 = np.full(count, -1e9)
        """The danced beat at which the last change of recording began, (A,)."""
        self._origin: Float64 = np.zeros((2, count))
        self._limits: Int32 = np.zeros((2, count, 2), np.int32)
        self._signs: Int64 = np.zeros((2, count), np.int64)
        self._kept: Float32 = np.zeros((count, _MOMENTS, FEATURES), np.float32)
        self._before: Float32 = np.zeros((count, FEATURES), np.float32)
        self._now: Float32 = np.zeros((count, FEATURES), np.float32)
        self._own: Float32 = np.zeros(DIMENSIONS, np.float32)
        self._far: Float32 = np.zeros(bank.count, np.float32)
        self._told: Float32 = np.zeros((count, 3, 3 * UPPER_COUNT), np.float32)
        self._told_moment: Int64 = np.full(count, NEVER, np.int64)
        self._near: Float32 = np.zeros(bank.told.centres.shape[1], np.float32)
        self._since: Float64 = np.full(count, np.inf)
        self._danced_before: Float64 = np.zeros(count)
        self._offsets = np.array(SKELETON.offsets, np.float32)
        self._parents = np.array(SKELETON.parents, np.int32)

    @property
    def active(self) -> bool:
        """Whether any dancer is textured, or will be."""
        return self.bank.count > 0 and bool(self.level.any() or self._variation.any(TEXTURE))

    def beats_at(self, phase: Float64) -> Float64:
        """Return the beats danced so far by dancers at `phase` (A,) of the present measure, (A,)."""
        return np.asarray((self._variation.measure + phase) * self._beats)

    def tick(self, phase: Float64, position: Float32, rotation: Float32, dt: float) -> None:
        """Record the legs at `position` (A, 9, 3) and `rotation` (A, 9, 4) for this tick, and make the choices due.

        Dancers without texture cost nothing and use up no turn.
        """
        if not self.active:
            self._since[:] = np.inf
            return
        danced = self.beats_at(phase)
        measure_legs(self._now, position, rotation)
        new = ~np.isfinite(self._since)
        if new.any():
            self._since[new], self._before[new], self._danced_before[new] = danced[new], self._now[new], danced[new]
            self._kept[new] = self._now[new, None]
        record_moments(self._kept, self._before, self._now, self._danced_before, danced, _EIGHTHS)
        self._before[:], self._danced_before[:] = self._now, danced
        wanted = self._variation[TEXTURE]
        told = self.bank.told
        follow_legs(
            self._told, self._told_moment, (wanted > 0.0) | (self.level > 0.0), danced, self._kept, self._near,
            told.middle, told.scale, told.centres, told.weights, told.slopes,
        )  # fmt: skip
        line = np.floor(danced - PREFIX).astype(np.int64)
        due = ((wanted > 0.0) | (self.level > 0.0)) & (line > self.chosen_beat) & (danced >= self.switch_beat + BLEND)
        due &= line - 0.5 >= self._since
        for dancer in np.flatnonzero(due)[: -(-len(due) // CHOICE_TICKS)].tolist():
            self._choose(dancer, int(line[dancer]), float(danced[dancer]))
        self._fade(wanted, dt)

    def _fade(self, wanted: Float64, dt: float) -> None:
        part = 1.0 - math.exp2(-dt / FADE_HALFLIFE)
        self.level += (part * (wanted * (self.fragment >= 0) - self.level)).astype(np.float32)
        out = (wanted == 0.0) & (self.level < 1e-3)
        self.level[out] = 0.0
        self.fragment[out], self.chosen_beat[out] = -1, NEVER

    def _choose(self, dancer: int, line: int, danced: float) -> None:
        """Choose the beat of the recordings for `dancer` from the danced beat `line` on."""
        bank, last = self.bank, int(self.fragment[dancer])
        write_prefix(self._own, self._kept[dancer], line)
        going = -1
        if last >= 0:
            then = last + int(line - self.chosen_beat[dancer])
            if then < bank.count and bank.clip_first[then] == bank.clip_first[last]:
                going = then
        join = SWITCH_COST * bank.spread
        best = nearest_fragment(
            self._far, bank.leg_features, self._own, going, join, DISTANCE_JITTER, self._seed, dancer
        )
        self.fragment[dancer], self.chosen_beat[dancer] = best, line
        if best == going:
            return
        origin, ends = float(bank.begin[best] - PER_BEAT * line), (bank.clip_first[best], bank.clip_last[best])
        if last >= 0:
            self._origin[1, dancer], self._limits[1, dancer] = self._origin[0, dancer], self._limits[0, dancer]
        else:
            self._origin[1, dancer], self._limits[1, dancer] = origin, ends
        self._origin[0, dancer], self._limits[0, dancer] = origin, ends
        self.switch_beat[dancer] = danced
        at, limits = self._origin[:, dancer] + PER_BEAT * danced, self._limits[:, dancer]
        whole, known = bool(self.level[dancer] > FULL_TEXTURE), int(self._signs[0, dancer])
        self._signs[1, dancer] = known
        self._signs[0, dancer] = signs_of(
            bank.upper, at[0], limits[0], at[1], limits[1], known, bank.mean_rotations, whole
        )
        if last < 0:
            self._signs[1, dancer] = self._signs[0, dancer]

    def apply(self, phase: Float64, position: Float32, rotation: Float32, rows: Int32 | None = None) -> None:
        """Texture the world poses `position` (A, J, 3) and `rotation` (A, J, 4) at `phase` (A,) of the measure, or only
        those of the dancers `rows` (n,), (n, J, 3) and (n, J, 4).

        Changes nothing but the poses.
        """
        if not (self.bank.count and self.level.any()):
            return
        bank, danced, head = self.bank, self.beats_at(phase), self._variation[HEAD].astype(np.float32)
        if rows is None:
            blend_upper_bodies(
                position, rotation, danced, self.level, self._origin, self._limits, self.switch_beat, BLEND,
                self._signs, bank.upper, self._offsets, self._parents, head, self._told, self._told_moment,
            )  # fmt: skip
            return
        limits = np.ascontiguousarray(self._limits[:, rows])
        origin, signs = np.ascontiguousarray(self._origin[:, rows]), np.ascontiguousarray(self._signs[:, rows])
        blend_upper_bodies(
            position, rotation, danced[rows], self.level[rows], origin, limits, self.switch_beat[rows], BLEND,
            signs, bank.upper, self._offsets, self._parents, head[rows], self._told[rows], self._told_moment[rows],
        )  # fmt: skip
