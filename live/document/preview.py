"""A second, silent engine: a range of measures is simulated aside, so that it can be looked at before it is danced.

It runs the same show in virtual time, without music, sound or picture, and keeps a snapshot of each measure. Asked for
a measure it goes on from the nearest one. An edited patch is taken as a running show takes it: from the last snapshot
before the first measure that changed.
"""

import contextlib
import copy
import math
from bisect import bisect_right
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, Final, Literal, NamedTuple

import numpy as np

from live.agents.evolutions.dry_run import DryRunResult, simulate_plan
from live.agents.evolutions.next_formations import NextFormation, rank_formations
from live.agents.formations.formation import Formation
from live.agents.formations.formation_spec import FormationSpec, spec_from_table
from live.agents.formations.like import resolved
from live.base.arrays import Bool, Float32, Float64, Int32
from live.base.errors import PersonError
from live.base.stage_snapshot import StageView
from live.clock.ticks import TICK
from live.graph.motion_graph import MotionGraph
from live.motion.editing.facing import heading_of
from live.rehearse.lint import lint_show
from live.rehearse.open_ends import OpenEnd, ScoreEnds
from live.show.group.dry_run import REACH_TOLERANCE
from live.show.loader import LoadedShow
from live.show.patch.patch import Patch
from live.show.patch.section_elements import ElementSection
from live.show.patch.section_score import SegmentSection
from live.show.score.division_tree import Branch, DivisionTree, Kind
from live.show.score.playhead import Playhead
from live.show.score.score import section_timings
from live.show.show import Show
from live.show.state.snapshot import Snapshotter, restore
from live.show.view.next_formations import FEWEST_DANCERS, known_formations, standing_of

TICKS_PER_SAMPLE: Final = 4
"""Ticks between two kept positions: 16 a second."""
AFTER_LINE: Final = 6
"""Ticks after a measure line from which on its snapshot is taken."""
MAX_SNAPSHOT_BYTES: Final = 200_000_000
"""Where snapshots take more memory, every second one is dropped; measures between are simulated again."""
MAX_MEASURE: Final = 10_000
"""Last measure that can be asked for."""
MAX_LOOK: Final = 1000
"""Measures in which the first change of a score is looked for."""
MAX_FOUND: Final = 200
"""Maximum number of meetings, and of ways that are too long, that are told."""
SCORE_KINDS: Final = ("segment", "sequence", "element", "at", "signal", "regroup", "improvise", "curve")
"""Lists whose entries act from their measure on."""


@dataclass(frozen=True, slots=True, eq=False)
class Positions:
    """Where everybody stands at one tick."""

    tick: int
    measure: float
    """Danced measures so far: 2.5 is the middle of the third."""
    place: Float32
    """(A, 2) [m]."""
    heading: Float32
    """(A,) [rad]."""
    node: Int32
    """What they dance, (A,)."""
    present: Int32
    """0 for those who are not on the stage, else the number of their group, from 1, (A,)."""


class _Snapshot(NamedTuple):
    measure: int
    """From 0."""
    tick: int
    data: bytes
    loaded: LoadedShow
    """The show as it was written then."""


class PreviewEngine:
    """The preview of one show. One thread; slow calls of it belong into a process of their own."""

    def __init__(self, loaded: LoadedShow, *, seed: int | None = None) -> None:
        """`loaded` is the show as it is written; PersonError if it does not start."""
        self._loaded, self._seed = loaded, seed
        self.on_tick: Callable[[], None] = lambda: None
        """Called after each simulated tick; what it raises ends the question, and the next one goes on from there."""
        self._begin(loaded.start(seed=seed))

    def _begin(self, show: Show) -> None:
        self._show, self._tick = show, round(show.time / TICK)
        self._snapshots: list[_Snapshot] = []
        self._samples: list[Positions] = []
        self._division = DivisionTree()
        self._snapshotter = Snapshotter(show)
        self._snapshot_due: int | None = None

    @property
    def patch(self) -> Patch:
        """The patch that is previewed."""
        return self._loaded.patch

    @property
    def graph(self) -> MotionGraph:
        """The motion graph of its steps."""
        return self._show.graph

    @property
    def seed(self) -> int:
        """The seed of the show."""
        return self._show.seed

    def spec(self, table: dict[str, Any]) -> FormationSpec:
        """Return the spec of a formation's table, which may be like one of the patch; PersonError if it is invalid."""
        return resolved(spec_from_table(table), self._show.motion.evolutions.written_formation)

    def formation(self, words: str, count: int) -> Formation:
        """Return the formation with this name or notation for `count` dancers; PersonError if there is none."""
        return self._show.motion.evolutions.formation(words, count)

    def select(self, words: str, place: Float32) -> Bool:
        """Return which dancers, at `place` (A, 2) [m], a selection means, (A,); PersonError for words without one."""
        return self._show.casting.select(words, place)

    @property
    def measures(self) -> int:
        """Number of whole measures that are simulated."""
        return max(int(self._samples[-1].measure), 0) if self._samples else 0

    def branch(self, patch: Patch) -> "PreviewEngine":
        """Return the preview of another patch beside this one, which stays as it is and shares the measures before the
        first change. PersonError if it does not start."""
        beside = copy.copy(self)
        beside._take(patch)  # replaces what the two share
        return beside

    def set_patch(self, patch: Patch) -> None:
        """Preview another patch: measures before its first change stay. PersonError if it does not start."""
        if _is_danced_alike(self._loaded.patch, patch):
            loaded = replace(self._loaded, patch=patch)
            loaded.start(seed=self._seed)
            self._loaded = loaded
            return
        self._take(patch)

    def _take(self, patch: Patch) -> None:
        """Preview another patch with a show of its own."""
        first = first_change(self._loaded.patch, patch)
        loaded = replace(self._loaded, patch=patch)
        fresh = loaded.start(seed=self._seed)
        former = self._nearest(first - 2) if first is not None else None
        if former is None:
            self._loaded = loaded
            self._begin(fresh)
            return
        show = restore(former.loaded, former.data)
        show.hot_swap.adopt(fresh)
        show.motion.withdraw(former.measure + 1)
        self._loaded = loaded
        snapshots = [one for one in self._snapshots if one.tick <= former.tick]
        samples = [one for one in self._samples if one.tick <= former.tick]
        division = self._division.until(former.measure)
        self._begin(show)
        self._tick, self._snapshots, self._samples = former.tick, snapshots, samples
        self._division = division

    def _nearest(self, measure: int) -> _Snapshot | None:
        """Return the last snapshot in or before a measure (from 0)."""
        index = bisect_right([one.measure for one in self._snapshots], measure) - 1
        return self._snapshots[index] if index >= 0 else None

    def run_to(self, measure: float) -> None:
        """Simulate until so many measures have been danced."""
        show = self._show
        while show.danced_beats < measure * show.desk.beats:
            self._step()

    def _step(self) -> None:
        show = self._show
        self._tick += 1
        if show.tick(self._tick * TICK):
            self._snapshot_due = self._tick + AFTER_LINE
        self._division.observe(show)
        if self._snapshot_due is not None and self._tick >= self._snapshot_due:
            taken = self._snapshotter.capture(self._tick)
            if taken is not None:
                self._snapshots.append(_Snapshot(show.span.number, self._tick, taken.seal(), self._loaded))
                self._snapshot_due = None
                if len(self._snapshots) * len(self._snapshots[-1].data) > MAX_SNAPSHOT_BYTES:
                    del self._snapshots[1::2]
        if self._tick % TICKS_PER_SAMPLE == 0 and show.span.number >= 0:
            measure, dancers = show.danced_beats / show.desk.beats, show.dancers
            heading = heading_of(dancers.leg_rotation[:, 0]).astype(np.float32)
            self._samples.append(
                Positions(
                    self._tick,
                    measure,
                    dancers.drawn_hips.copy(),
                    heading,
                    dancers.node.copy(),
                    show.motion.group_states()[: len(heading)],
                )
            )
        self.on_tick()

    def samples(self, first: float, last: float) -> list[Positions]:
        """Return where everybody stands between `first` and `last` danced measures, 16 times a second."""
        self.run_to(last + 0.1)
        measures = [one.measure for one in self._samples]
        return self._samples[bisect_right(measures, first - 1e-6) : bisect_right(measures, last + 1e-6)]

    def measures_of(self, number: int, kind: Literal["segment", "element"] = "segment") -> tuple[int, int]:
        """Return the measures (from 1) in which a segment or an element of the patch (from 0) is danced first;
        PersonError if it is not danced unless somebody leads there."""
        entries: tuple[SegmentSection | ElementSection, ...] = getattr(self.patch, kind)
        if not 0 <= number < len(entries):
            raise PersonError(f"there is no {kind} {number + 1}", f"there are {len(entries)}")
        entry, playhead = entries[number], Playhead(section_timings(self.patch))
        wanted = self._show.score_runner.score.place_of(entry.section, entry.measure)
        for measure in range(0 if wanted is None else MAX_MEASURE):
            playhead.begin_measure(measure)
            place = playhead.place(measure)
            if (place.section, place.measure) == wanted:
                return measure + 1, measure + math.ceil(entry.measure % 1.0 + entry.measures - 1e-9)
        raise PersonError(f"{kind} {number + 1} is never danced", "see its section and measure")

    def next_formations(self, element: int) -> tuple[int, OpenEnd | None, tuple[NextFormation, ...]]:
        """Return the measure (from 1) with whose line an element of the patch (from 0) is over, its end as it is
        written, and the formations that its dancers could go into then, the best one first; none if something moves
        them at once. PersonError if it is not danced unless somebody leads there."""
        first, last = self.measures_of(element, "element")
        show, before = self._show, self.at(first - 1.0)
        end = ScoreEnds(self.patch, show.casting, before.place).of(self.patch.element[element])
        after = self.at(float(last))
        present = after.present != 0
        who = present if end is None else end.who & present
        if end is None or end.room < 1 or np.count_nonzero(who) < FEWEST_DANCERS:
            return last + 1, end, ()
        standing = standing_of(show, who, after.place, before.place, present=present, measures=end.room)
        return last + 1, end, rank_formations(standing, known_formations(show, int(who.sum())))

    def dancers_of(self, segment: int) -> Bool:
        """Return who dances a segment of the patch (from 0), as they stand at its beginning, (A,)."""
        first, _ = self.measures_of(segment)
        return self._show.casting.select(self.patch.segment[segment].group, self.at(first - 1.0).place)

    def at(self, measure: float) -> Positions:
        """Return where everybody stands after so many danced measures."""
        self.run_to(measure + 0.1)
        index = bisect_right([one.measure for one in self._samples], measure + 1e-6) - 1
        return self._samples[max(index, 0)]

    def view_at(self, measure: float) -> StageView:
        """Return the drawing snapshot, with all joints, after so many danced measures."""
        show, tick = self._rerun(measure)
        view = show.view()
        view.detailed = True  # a page has a camera of its own
        show.fill(view, tick * TICK)
        return view

    def bodies(self, first: float, last: float) -> Iterator[tuple[int, Float32]]:
        """Yield tick and joints (A, J, 3) [m] of each of the `samples` between `first` and `last` danced measures."""
        self.run_to(last + 0.1)
        show, tick = self._rerun(first)
        view, count = show.view(), len(self._samples[-1].place)
        view.detailed = True
        while show.danced_beats <= last * show.desk.beats:
            if tick % TICKS_PER_SAMPLE == 0:
                show.fill(view, tick * TICK)
                yield tick, view.joint_position[:count]
            tick += 1
            show.tick(tick * TICK)
            self.on_tick()

    def _rerun(self, measure: float) -> tuple[Show, int]:
        """Return a show that has danced so many measures again, since the nearest snapshot, and its tick."""
        self.run_to(measure + 0.1)
        former = self._nearest(int(measure - 0.1))
        if former is None:
            show, tick = self._loaded.start(seed=self._seed), 0
        else:
            show, tick = restore(former.loaded, former.data), former.tick
        while show.danced_beats < measure * show.desk.beats:
            tick += 1
            show.tick(tick * TICK)
            self.on_tick()
        return show, tick

    def plan(self, first: int, last: int, patch: Patch | None = None) -> DryRunResult:
        """Return the planned ways of measures `first` to `last` (from 1), from where everybody stands before them: of
        this patch, or of an edited one that is not previewed otherwise. PersonError if it does not start.

        Dancers moved by elements are assumed to stay.
        """
        before, show = self.at(first - 1.0), self._show
        if patch is not None:
            show = show.hot_swap.make_show(patch, show.graph)  # type: ignore[assignment]
        evolutions = show.motion.evolutions
        segments = [
            replace(segment, start=measure - first + 1)
            for measure in range(first - 1, last)
            for segment in evolutions.score_segments(measure)
        ]
        half = (self.patch.stage.width / 2.0, self.patch.stage.depth / 2.0)
        return simulate_plan(
            show.casting.roster, evolutions.repertoire, segments, before.place, measures=last - first + 1,
            headings=before.heading, measure_beats=float(self.patch.clock.beats_per_measure), half=half,
            radius=self._show.motion.model.radius, seed=show.seed, keep_ways=True, available=before.present != 0,
        )  # fmt: skip

    def division(self, first: int, last: int) -> dict[Kind, list[Branch]]:
        """Return how the groups are divided in measures `first` to `last` (from 1), as trees for steps, motion and
        values: groups with their parts, and those with theirs."""
        self.run_to(last)
        names = tuple(group.name for group in self.patch.group)
        return self._division.trees(names, first - 1, last - 1)

    def reach(self) -> Float64:
        """Return how far steps and corrections carry each dancer in a measure [m], (A,)."""
        reach = self._show.scheduler.step_reach() + self.patch.locomotion.correction_m
        return np.broadcast_to(np.asarray(reach, np.float64), self._show.motion.model.radius.shape)

    def notes(self) -> list[str]:
        """Return the doubts of `live check` about the show."""
        return [
            words
            for section in lint_show(self._loaded.start(seed=self._seed, begin=False))
            for words in section.warnings
        ]

    def describe(self, node: int) -> str:
        """Return the step of a node in words."""
        return self._show.graph.library.describe(node)


def _is_danced_alike(old: Patch, new: Patch) -> bool:
    """Whether two patches differ in the music alone, not in its tempo; the preview does not hear it."""
    same_tempo = old.music.known_tempo == new.music.known_tempo
    return same_tempo and old.model_copy(update={"music": new.music}) == new


def led_patch(patch: Patch) -> Patch:
    """Return the patch with sections that neither wait nor repeat: each leads to the one written below it."""
    plain = {"repeat": 1, "wait": False, "then": None}
    return patch.model_copy(update={"section": tuple(one.model_copy(update=plain) for one in patch.section)})


def first_change(old: Patch, new: Patch) -> int | None:
    """Return the measure (from 1) in which two patches are danced differently for the first time, or a late one if they
    are danced alike soon; None if it cannot be told."""
    shapes = _changed_formations(old, new)
    for name in Patch.model_fields:
        if name in (*SCORE_KINDS, "music", "formation", "evolution"):
            continue
        values = getattr(old, name)
        if values != getattr(new, name) or (shapes and any(each in repr(values).casefold() for each in shapes)):
            return None
    if old.music.known_tempo != new.music.known_tempo:
        return None
    changed: list[Any] = []
    for name in SCORE_KINDS:
        before, after = (set(map(repr, getattr(patch, name))) for patch in (old, new))
        for patch, other in ((old, after), (new, before)):
            changed += [
                entry
                for entry in getattr(patch, name)
                if repr(entry) not in other or (shapes and any(each in repr(entry).casefold() for each in shapes))
            ]
        if [repr(one) for one in getattr(old, name)] != [repr(one) for one in getattr(new, name)] and before == after:
            return None  # another order
    if any(entry.measure is None for entry in changed):
        return None
    if changed:
        return _first_danced(new, changed)
    return MAX_LOOK if shapes else None


def _changed_formations(old: Patch, new: Patch) -> set[str]:
    """Return the names, quoted and in small letters, of formations and evolutions that one of two patches lacks or has
    otherwise."""
    before, after = (_shapes(patch) for patch in (old, new))
    changed, seen = {name for name in before.keys() | after.keys() if before.get(name) != after.get(name)}, -1
    while len(changed) > seen:  # what is like a changed one is changed, too
        seen = len(changed)
        for name, table in (*before.items(), *after.items()):
            used = {str(table.get(key)).casefold() for key in ("like", "along", "into")}
            if used & changed:
                changed.add(name)
    return {repr(name) for name in changed}


def _shapes(patch: Patch) -> dict[str, dict[str, Any]]:
    """Return the tables of the formations and evolutions of a patch, by name in small letters."""
    evolutions = [one.model_dump(exclude_unset=True) for one in patch.evolution]
    return {str(one.get("name", "")).casefold(): one for one in (*evolutions, *patch.formation)}


def _first_danced(patch: Patch, entries: list[Any]) -> int | None:
    """Return the measure (from 1) in which the first of some entries is danced, while nobody leads elsewhere; a late
    one if none is, soon."""
    playhead = Playhead(section_timings(patch))
    names = [section.name.casefold() for section in playhead.sections]
    wanted = set[tuple[int, int]]()
    for entry in entries:
        measure = int(entry.measure) - 1
        if entry.section is not None:
            if entry.section.casefold() not in names:
                return None
            wanted.add((names.index(entry.section.casefold()), measure))
            continue
        with contextlib.suppress(ValueError):  # it never comes
            place = playhead.place_of_written(measure)
            wanted.add((place.section, place.measure))
    for measure in range(MAX_LOOK if wanted else 0):
        playhead.begin_measure(measure)
        place = playhead.place(measure)
        if (place.section, place.measure) in wanted:
            return measure + 1
    return MAX_LOOK


def preview_values(engine: PreviewEngine, first: int, last: int) -> dict[str, Any]:
    """Return what measures `first` to `last` (from 1) look like, as values for JSON."""
    if not 1 <= first <= last:
        raise PersonError(f"measures {first} to {last}: the first one comes last", "--from 5 --to 8")
    measures = []
    for measure in range(first, last + 2):
        there = engine.at(measure - 1.0)
        columns = there.place.tolist(), there.heading.tolist(), there.node.tolist(), there.present.tolist()
        dancers = [
            [round(x, 3), round(z, 3), round(turn, 4), engine.describe(node)] if here else None
            for (x, z), turn, node, here in zip(*columns, strict=True)
        ]
        measures.append({"measure": measure, "time_s": round(there.tick * TICK, 3), "dancers": dancers})
    plan = engine.plan(first, last)
    return {
        "from": first,
        "to": last,
        "measures": measures,
        "ways": way_values(plan),
        **plan_faults(engine, plan, first),
        "division": division_values(engine, first, last),
        "notes": engine.notes(),
    }


def division_values(engine: PreviewEngine, first: int, last: int) -> dict[str, Any]:
    """Return the division of the groups in measures `first` to `last` (from 1)."""
    trees = engine.division(first, last)
    return {kind: [branch.as_json() for branch in roots] for kind, roots in trees.items()}


def way_values(plan: DryRunResult) -> list[list[list[float]]]:
    """Return the planned way of each dancer: places (x, z) [m], 32 in each measure."""
    values: list[list[list[float]]] = np.round(plan.ways.transpose(1, 0, 2).astype(np.float64), 3).tolist()
    return values


def plan_faults(engine: PreviewEngine, plan: DryRunResult, first: int) -> dict[str, Any]:
    """Return who would meet, and whose way is too long, in a plan that begins with measure `first` (from 1)."""
    nearest = sorted(plan.too_near, key=lambda one: one.distance)[:MAX_FOUND]
    far = plan.too_far(engine.reach() + REACH_TOLERANCE)[:MAX_FOUND]
    return {
        "meetings": [
            {
                "measure": first + one.measure,
                "dancers": [one.first + 1, one.second + 1],
                "distance": round(one.distance, 3),
            }
            for one in nearest
        ],
        "too_far": [
            {
                "measure": first + one.measure,
                "dancer": one.dancer + 1,
                "distance": round(one.distance, 3),
                "reach": round(one.reach, 3),
            }
            for one in far
        ],
    }
