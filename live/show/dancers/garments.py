"""What moves by itself on the dancers of a show: who wears what, the simulation at ticks, and its pictures.

How many garments are simulated, and in how many substeps, follows from their number alone; the clock has no say in it.
"""

from typing import TYPE_CHECKING, Final

import numpy as np

from live.base.arrays import Bool, Float32, Float64, Int32
from live.base.body.appearance import COSTUME, COSTUMES, EXTRAS, FABRICS, HAIR, HAIRS, MOVING
from live.base.body.catalogue import BODIES, DEFAULT_BODY
from live.base.picture_parameters import (
    BY_ADDRESS,
    EYE,
    GROUP_PARAMETERS,
    PART_COUNT,
    STYLE_ADDRESS_PREFIX,
    STYLE_SIZE,
    STYLES_START,
)
from live.base.stage_snapshot import StageView
from live.clock.ticks import TICK
from live.control.events.events import TicksSkipped
from live.motion.cloth.fabric import fabric_of
from live.motion.cloth.garment_batch import GarmentBatch
from live.motion.cloth.garment_catalogue import PATTERN_NAMES, PATTERNS, garments_of
from live.motion.cloth.limb_kernels import LANES
from live.motion.cloth.pattern import CompiledPattern, compile_pattern
from live.motion.skeleton import JOINT_COUNT
from live.render.body.body_limbs import body_sections
from live.show.dancers.character_casting import bodies_of
from live.show.patch.patch import Patch
from live.show.stages.now import Now
from live.show.view.appearance import pick_names

if TYPE_CHECKING:
    from live.show.desk.parameters import Parameters
    from live.show.group.division import Division
    from live.show.view.appearance import Appearances

SUBSTEPS: Final = 3
"""Substeps of a tick."""
FEWEST_SUBSTEPS: Final = 2
BUDGET: Final = 56_000
"""Particles times substeps in a tick: 50 dancers with a skirt and long hair, and some more. Beyond that there are fewer
substeps, then those who are farthest from the camera have garments that are fixed to the body."""
JUMP: Final = 0.4
"""A dancer whose hips are so much farther in a tick [m] has not gone there: their garments begin anew."""
_SEED: Final = 41
_PLACES: Final = {
    name: GROUP_PARAMETERS[STYLE_ADDRESS_PREFIX + name].first - STYLES_START
    for name in ("fabric", "extras", "cloth", "skirt")
}
_READ: Final = np.array(list(_PLACES.values()))
_WIND: Final = BY_ADDRESS["/dance/cloth/wind"].row_slice
_compiled: dict[tuple[str, str], CompiledPattern] = {}


def _pattern(name: str, fabric: str) -> CompiledPattern:
    """Return a pattern of a fabric, compiled once."""
    key = name, fabric if PATTERNS[name].kind == "cloth" else ""
    if key not in _compiled:
        _compiled[key] = compile_pattern(PATTERNS[name], fabric_of(PATTERNS[name].kind, fabric))
    return _compiled[key]


class Garments:
    """The garments of one show. Thread: the show's.

    `tick` advances the simulated ones, `show` fills them and the others into a view.
    """

    EVENTS = (TicksSkipped,)

    def __init__(
        self, patch: Patch, division: "Division", parameters: "Parameters", appearances: "Appearances", *, seed: int
    ) -> None:
        self._division, self._parameters, self._appearances, self._seed = division, parameters, appearances, seed
        count = len(division.part)
        self._bodies = _bodies(patch, count)
        self.simulated: dict[str, GarmentBatch] = {}
        """Simulated garments, by the names of pattern and fabric with a `/` between them."""
        self._skinned: dict[str, GarmentBatch] = {}
        self.substeps = SUBSTEPS
        self._measure = -1
        self._joint_position: Float32 = np.zeros((count, JOINT_COUNT, 3), np.float32)
        self._joint_rotation: Float32 = np.zeros((count, JOINT_COUNT, 4), np.float32)
        self._hips: Float32 = np.zeros((count, 3), np.float32)
        self._seen: Bool = np.zeros(count, np.bool_)
        self._chosen: Bool = np.zeros(count, np.bool_)
        """Whose garments are simulated, (A,)."""
        for body in {*self._bodies} & {*BODIES}:
            body_sections(body)  # now, because it may take a while
        for name in PATTERNS:
            for fabric in FABRICS:
                _pattern(name, fabric)
        self._known: tuple[Float64, Int32, Int32] | None = None  # what the last assignment followed from

    @property
    def any(self) -> bool:
        """Whether any garment is simulated."""
        return bool(self.simulated)

    @property
    def joints(self) -> tuple[Float32, Float32]:
        """Arrays for the joints at the tick: positions (A, J, 3) [m] and rotations (A, J, 4)."""
        return self._joint_position, self._joint_rotation

    def handle(self, event: TicksSkipped, now: Now) -> None:
        """Begin anew after a stall."""
        self.restart()

    def restart(self) -> None:
        """Let all garments begin anew, as they hang on the body."""
        for batch in self.simulated.values():
            batch.restart()

    def apply_patch(self, fresh: "Garments") -> None:
        """Take over the bodies of an edited patch."""
        self._bodies, self._known = fresh._bodies, None

    # -- who wears what ------------------------------------------------------------------------------------------------

    def assign(self, measure: int) -> None:
        """Give everybody what they wear now; call it in each tick. `measure`: number of the measure."""
        said = self._parameters.picture[STYLES_START:].reshape(PART_COUNT, STYLE_SIZE)[:, _READ]
        part, rows, known = self._division.part, self._appearances.rows(), self._known
        same = known is not None and np.array_equal(said, known[0]) and np.array_equal(part, known[1])
        same = same and known is not None and (rows is known[2] or np.array_equal(rows, known[2]))
        if same and (not self._skinned or measure == self._measure):
            return
        self._measure = measure
        self._known = said.copy(), part.copy(), rows
        worn, moving = self._worn(said[part], rows)
        self._choose(worn, moving)
        self._wear(self.simulated, worn, self._chosen)
        self._wear(self._skinned, worn, ~self._chosen)

    def _worn(self, said: Float64, rows: Int32) -> tuple[list[tuple[str, ...]], Bool]:
        """Return the names of everybody's garments, and whose may move, (A,)."""
        count = len(said)
        column = {name: place for place, name in enumerate(_PLACES)}
        chance = np.random.default_rng([self._seed, _SEED]).random((count, 3))
        fabric, extra, moving = (
            pick_names(said[:, column[name]].astype(np.int64), chance[:, place])
            for place, name in enumerate(("fabric", "extras", "cloth"))
        )
        worn: list[tuple[str, ...]] = [
            tuple(
                f"{name}/{FABRICS[fabric[a]]}"
                for name in garments_of(
                    COSTUMES[rows[a, COSTUME]],
                    HAIRS[rows[a, HAIR]],
                    EXTRAS[extra[a]],
                    skirt=float(said[a, column["skirt"]]),
                )
            )
            if self._bodies[a] in BODIES
            else ()
            for a in range(count)
        ]
        return worn, np.asarray(moving == MOVING.index("auto"))

    def _choose(self, worn: list[tuple[str, ...]], moving: Bool) -> None:
        """Choose whose garments are simulated, and in how many substeps: all if they fit into the budget, else those
        nearest to the camera."""
        cost = np.array([sum(PATTERNS[name.partition("/")[0]].count for name in names) for names in worn])
        cost[~moving] = 0
        particles = int(cost.sum())
        self.substeps = int(np.clip(BUDGET // max(particles, 1), FEWEST_SUBSTEPS, SUBSTEPS))
        chosen = moving & (cost > 0)
        if particles * self.substeps > BUDGET:
            away = np.linalg.norm(self._hips[:, :3] - self._parameters.picture[EYE], axis=1)
            order = np.lexsort((np.arange(len(cost)), np.round(away, 3)))
            fits = np.cumsum(cost[order]) * self.substeps <= BUDGET
            chosen[order[~fits]] = False
        self._chosen[:] = chosen

    def _wear(self, batches: dict[str, GarmentBatch], worn: list[tuple[str, ...]], who: Bool) -> None:
        wearers: dict[str, list[int]] = {}
        for a in np.flatnonzero(who).tolist():
            for name in worn[a]:
                wearers.setdefault(name, []).append(a)
        for name in sorted(batches.keys() - wearers.keys()):
            del batches[name]
        for name in sorted(wearers):
            if name not in batches:
                batches[name] = GarmentBatch(_pattern(*name.split("/")))
            batches[name].wear(
                np.array(wearers[name], np.int32), [body_sections(self._bodies[a]) for a in wearers[name]]
            )
        if list(batches) != sorted(batches):
            for name in sorted(batches):  # the same order whatever was worn before
                batches[name] = batches.pop(name)

    # -- ticks and pictures --------------------------------------------------------------------------------------------

    def tick(self, present: Bool) -> None:
        """Advance by a tick to the joints in `joints`; present (A,): who is on the stage."""
        hips = self._joint_position[:, 0]
        anew = np.flatnonzero((np.abs(hips - self._hips).max(axis=1) > JUMP) | ~present | ~self._seen)
        self._hips[:], self._seen[:] = hips, present
        wind = self._parameters.picture[_WIND].astype(np.float32)
        for batch in self.simulated.values():
            if len(anew):
                batch.restart(anew.astype(np.int32))
            batch.tick(self._joint_position, self._joint_rotation, wind, self.substeps, TICK)

    def show(self, view: StageView, age: float) -> None:
        """Fill the garments into a view that has its joints already, `age` [s] after the last tick."""
        batches = [(name, batch, False) for name, batch in self.simulated.items()]
        batches += [(name, batch, True) for name, batch in self._skinned.items()]
        particles = sum(batch.particles for _, batch, _ in batches)
        count = sum(batch.count for _, batch, _ in batches)
        if len(view.cloth_position) != particles or len(view.cloth_garment) != count:
            view.cloth_position = np.zeros((particles, 3), np.float32)
            view.cloth_garment = np.zeros((count, 3), np.int32)
        first, row = 0, 0
        for name, batch, rigid in batches:
            size, n = batch.compiled.pattern.count, batch.count
            garment = view.cloth_garment[row : row + n]
            garment[:, 0] = batch.rows.ravel()[:n]
            garment[:, 1] = PATTERN_NAMES.index(name.partition("/")[0])
            garment[:, 2] = first + size * np.arange(n)
            out = view.cloth_position[first : first + size * n].reshape(n, size, 3)
            batch.draw(view.joint_position, view.joint_rotation, out, age=age, dt=TICK, skinned=rigid)
            first, row = first + size * n, row + n

    def hashed(self) -> tuple[Float32, ...]:
        """Return the arrays that belong to the hash of the state; none if nothing is simulated."""
        return tuple(array for batch in self.simulated.values() for array in (batch.position, batch.velocity))

    # -- snapshots -----------------------------------------------------------------------------------------------------

    def rebuild(self) -> None:
        """Compute what a snapshot lacks: patterns and bodies of the batches, and who wears what as skin."""
        for name, batch in self.simulated.items():
            batch.compiled = _pattern(*name.split("/"))
            batch.fit([body_sections(self._bodies[a]) for a in batch.rows.ravel()[: batch.count].tolist()])
        said = self._parameters.picture[STYLES_START:].reshape(PART_COUNT, STYLE_SIZE)[:, _READ]
        part, rows = self._division.part, self._appearances.rows()
        self._known = said.copy(), part.copy(), rows
        self._wear(self._skinned, self._worn(said[part], rows)[0], ~self._chosen)

    def is_consistent(self) -> bool:
        """Whether batches have known names, and arrays of the sizes that their patterns and dancers need."""
        return all(_fits(name, batch, len(self._seen)) for name, batch in self.simulated.items())


def _fits(name: str, batch: GarmentBatch, dancers: int) -> bool:
    pattern, _, fabric = name.partition("/")
    if pattern not in PATTERNS or fabric not in FABRICS:
        return False
    one, blocks = _pattern(pattern, fabric), len(batch.rows)
    shapes = (
        (batch.rows, (blocks, LANES)), (batch.position, (blocks, 3, one.pattern.count, LANES)),
        (batch.velocity, (blocks, 3, one.pattern.count, LANES)), (batch.joints, (blocks, 7, len(one.joints), LANES)),
        (batch.carrier, (blocks, 7, LANES)), (batch.fresh, (blocks, LANES)),
    )  # fmt: skip
    whole = all(array.shape == shape for array, shape in shapes)
    return whole and 0 < batch.count <= dancers and -(-batch.count // LANES) == blocks


def _bodies(patch: Patch, count: int) -> tuple[str, ...]:
    """Return the body of each dancer."""
    said = bodies_of(patch)[:count]
    return (*said, *(DEFAULT_BODY for _ in range(count - len(said))))
