"""Garments of one pattern and fabric on several dancers: their state, its ticks and its pictures."""

import operator as op
from typing import Any

import numpy as np

from live.base.arrays import Float32, Int32
from live.base.row_ranges import run_rows
from live.motion.cloth.body_sections import COEFFICIENTS, LIMB_COUNT, LIMBS, SECTION_COLUMNS, half_widths
from live.motion.cloth.cloth_kernels import step_garments
from live.motion.cloth.limb_kernels import AXES, BOUND, CAPS, LANES, LENGTH, LIMB_ROWS, MIDDLE, PER_LENGTH, SIDES
from live.motion.cloth.pattern import THICKNESS, CompiledPattern
from live.motion.cloth.picture_kernels import draw_garments
from live.motion.skeleton import SKELETON

_REST = SKELETON.rest_positions()


def limb_rows(sections: Float32) -> Float32:
    """Return all limbs of a body as the kernels want them, in their joints' axes, (LIMB_ROWS, LIMB_COUNT).

    sections (LIMB_COUNT, SECTION_COLUMNS): its cross-sections.
    """
    if sections.shape != (LIMB_COUNT, SECTION_COLUMNS):
        raise ValueError(f"{sections.shape}: cross-sections of {LIMB_COUNT} limbs expected")
    out = np.zeros((LIMB_ROWS, LIMB_COUNT))
    for k, limb in enumerate(LIMBS):
        out[MIDDLE : MIDDLE + 3, k] = np.subtract(limb.start, _REST[limb.joint])
        out[AXES : AXES + 9, k] = limb.axes().T.ravel()
        out[SIDES : SIDES + 3 * COEFFICIENTS, k] = sections[k, : 3 * COEFFICIENTS]
        out[CAPS : CAPS + 2, k] = sections[k, -2:]
        widest = max(max(half_widths(sections[k], place)) for place in np.linspace(0.0, 1.0, 11))
        out[BOUND, k] = (1.05 * max(widest, *(1.0 / sections[k, -2:])) + THICKNESS) ** 2
        out[LENGTH, k], out[PER_LENGTH, k] = limb.length, 1.0 / limb.length
    return out.astype(np.float32)


class GarmentBatch:
    """The garments of a pattern on n dancers, in blocks of LANES. Call `wear` first, then `tick`, and `draw` for each
    picture."""

    def __init__(self, compiled: CompiledPattern) -> None:
        self.compiled = compiled
        self.rows: Int32 = np.zeros((0, LANES), np.int32)
        """Dancers of each block, (B, LANES); the last one is repeated in lanes that nobody has."""
        self._sections: list[Float32] = []
        self.count = 0
        """Number of dancers n."""
        self._allocate(0)

    def _allocate(self, blocks: int) -> None:
        particles, joints = self.compiled.pattern.count, len(self.compiled.joints)
        self.position: Float32 = np.zeros((blocks, 3, particles, LANES), np.float32)
        """Particles [m], (B, 3, P, LANES)."""
        self.velocity: Float32 = np.zeros_like(self.position)
        """[m/s]"""
        self.joints: Float32 = np.zeros((blocks, 7, joints, LANES), np.float32)
        """Joints at the last tick, (B, 7, J, LANES)."""
        self.carrier: Float32 = np.zeros((blocks, 7, LANES), np.float32)
        """The first joint at the tick before, (B, 7, LANES)."""
        self.fresh = np.ones((blocks, LANES), np.uint8)
        """1 where a garment begins anew, as skin, (B, LANES)."""

    @property
    def particles(self) -> int:
        """Number of particles of all garments."""
        return self.count * self.compiled.pattern.count

    def wear(self, dancers: Int32, sections: list[Float32]) -> None:
        """Let the dancers `dancers` (n,) wear the garment, whose bodies have the cross-sections `sections` (n of them).

        Those who wore it before go on with the state that they have.
        """
        if np.array_equal(dancers, self.rows.ravel()[: self.count]) and all(map(op.is_, sections, self._sections)):
            return
        old: dict[int, tuple[int, int]] = {int(self.rows.flat[lane]): divmod(lane, LANES) for lane in range(self.count)}
        was: tuple[Any, ...] = self.position, self.velocity, self.joints, self.carrier, self.fresh
        self.count = len(dancers)
        blocks = -(-self.count // LANES)
        self._allocate(blocks)
        self.rows = np.zeros((blocks, LANES), np.int32)
        if not blocks:
            return
        self.rows.ravel()[:] = np.concatenate([dancers, np.full(blocks * LANES - self.count, dancers[-1])])
        self.fit(sections)
        for lane in range(blocks * LANES):
            block, i = divmod(lane, LANES)
            before = old.get(int(self.rows[block, i]))
            if before is not None:
                now: tuple[Any, ...] = self.position, self.velocity, self.joints, self.carrier, self.fresh
                for new, former in zip(now, was, strict=True):
                    new[block, ..., i] = former[before[0], ..., before[1]]

    def fit(self, sections: list[Float32]) -> None:
        """Fit the garments to bodies with the cross-sections `sections` (n of them)."""
        blocks, one, self._sections = len(self.rows), self.compiled, sections
        self._limbs = np.zeros((blocks, LIMB_ROWS, len(one.limbs), LANES), np.float32)
        self._rest = np.zeros((blocks, 6, one.pattern.count, LANES), np.float32)
        known: dict[int, tuple[Float32, Float32]] = {}
        for lane in range(blocks * LANES):
            block, i = divmod(lane, LANES)
            body = sections[min(lane, self.count - 1)]
            if id(body) not in known:
                known[id(body)] = one.rest(body), limb_rows(body)[:, one.limbs]
            self._rest[block, :, :, i], self._limbs[block, :, :, i] = known[id(body)]

    def restart(self, dancers: Int32 | None = None) -> None:
        """Let the garments of these dancers, or of all, begin anew at the next tick."""
        if dancers is None:
            self.fresh[:] = 1
        else:
            self.fresh[np.isin(self.rows, dancers)] = 1

    def tick(self, position: Float32, rotation: Float32, wind: Float32, substeps: int, dt: float) -> None:
        """Advance by `dt` [s] to the joints `position` (A, J, 3) [m] and `rotation` (A, J, 4), in `wind` (3,) [m/s]."""
        one = self.compiled

        def part(begin: int, end: int) -> None:
            step_garments(
                self.position, self.velocity, self.joints, self.carrier, self.fresh, position, rotation, self.rows,
                one.joints, one.standing, one.limb_joint, one.bridges, self._limbs, self._rest, one.by, one.weight,
                one.pattern.pinned_rows * one.pattern.columns, one.runs, one.amounts, one.limit_runs, one.limits,
                one.last_runs, one.last_limits, one.contacts, one.more_contacts, one.rings, one.areas, one.matter, wind,
                substeps, dt, begin, end,
            )  # fmt: skip

        run_rows(part, len(self.rows), least=1)

    def draw(self, position: Float32, rotation: Float32, out: Float32, *, age: float, dt: float, skinned: bool) -> None:
        """Write the particles in a picture `age` [s] after the last tick into `out` (n, rows * columns, 3) [m], row by
        row and column by column. The joints are those of the picture. `dt`: length of a tick [s]; `skinned`: without
        the simulation."""
        one = self.compiled

        def part(begin: int, end: int) -> None:
            draw_garments(
                self.position, self.velocity, self.joints, self.carrier, self.fresh, position, rotation, self.rows,
                one.joints, one.limb_joint, one.bridges, self._limbs, self._rest, one.by, one.weight,
                one.pattern.pinned_rows * one.pattern.columns, one.last_runs, one.last_limits, one.contacts,
                one.more_contacts, one.matter, one.order, age, dt, skinned, out, begin, end,
            )  # fmt: skip

        run_rows(part, len(self.rows), least=2)
