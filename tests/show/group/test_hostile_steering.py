"""Tests of motion under hostile steering: planted feet, stage limits, continuity and finite values."""

import math

import numpy as np
import pytest

from live.base.motion_parameters import OBEDIENCE
from live.clock.ticks import TICK
from live.control.events import events
from live.motion.quality.metrics import contact_slide_speeds
from live.show.assembly import assemble
from live.show.loader import load_from_patch
from live.show.patch.patch_reader import parse_patch
from live.show.patch.patch_search_path import PATCHES
from tests.fixtures.mostly_long import mostly_long

PATCH = """
name = "hostile"
seed = 5
reserve = 2
[clock]
bpm = 112
[stage]
width = 9.0
depth = 6.0
[[group]]
name = "all"
dancers = 12
steps = ["samba", "side step", "walk x2"]
travel_step = "walk"
size = [6.0, 4.0]
"""
BODY = 0.25
"""Tolerance of hips beyond the edge [m]: a dancer may stand on it with one foot."""


@pytest.fixture(scope="module")
def loaded():
    return load_from_patch(parse_patch(PATCH, "hostile.toml"), PATCHES / "hostile.toml")


@pytest.fixture
def show(loaded):
    return assemble(loaded.patch, loaded.graph)


class MotionRecorder:
    """Records the rendered motion of a show tick by tick."""

    def __init__(self, show):
        self.show, self.view = show, show.view()
        self.ticks = round(show.time / TICK)
        self.slides, self.positions, self.there = [], [], []
        self._contact = None

    def run(self, seconds, act=lambda tick: None):
        """Run `seconds`; `act` is called with the number of each tick before it is run."""
        for tick in range(self.ticks + 1, self.ticks + round(seconds / TICK) + 1):
            act(tick)
            self.show.tick(tick * TICK)
            self._look(tick * TICK)
        self.ticks = tick

    def _look(self, time):
        show, view = self.show, self.view
        show.fill(view, time)
        contact = show.dancers.contact(show.span.fraction(show.timeline.beat_at(time)))
        position, there = view.joint_position.copy(), view.present.copy()
        if self._contact is not None:
            both = there & self.there[-1]
            feet = np.stack([self.positions[-1], position])[:, both], np.stack([self._contact, contact])[:, both]
            self.slides.append(contact_slide_speeds(*feet, 1.0 / TICK))
        self.positions.append(position)
        self.there.append(there)
        self._contact = contact

    def check_all(self, *, staying=None):
        """Check all conditions; `staying`: dancers for the stage limit (default: all present)."""
        half = np.array([self.show.patch.stage.width, self.show.patch.stage.depth]) / 2
        beyond, there = self.beyond(half), np.array(self.there)
        beyond = beyond if staying is None else beyond[:, staying]
        assert beyond[there if staying is None else there[:, staying]].max() < BODY
        self.check_motion()

    def beyond(self, half):
        """Distance of the hips beyond the edges of a stage with half sizes `half` [m], (T, A)."""
        return (np.abs(np.array(self.positions)[:, :, 0][..., (0, 2)]) - half).max(axis=-1)

    def check_motion(self):
        """Check conditions apart from the stage limit: planted feet and continuous hips."""
        position, there = np.array(self.positions), np.array(self.there)
        assert np.isfinite(position).all()
        assert np.isfinite(self.show.state.position).all()
        slide = np.concatenate(self.slides)
        assert slide.size > 1000
        assert slide.mean() <= 0.03
        assert np.percentile(slide, 99) <= 0.15
        jumped = np.linalg.norm(np.diff(position[:, :, 0], axis=0), axis=-1) / TICK
        assert jumped[there[1:] & there[:-1]].max() < 5.0  # m/s, at 240 bpm: hips go, they are not put elsewhere


@pytest.mark.long
def test_motion_holds_when_tempo_jumps_stops_and_doubles(show):
    """From 60 to 180 within one beat, to half and double repeatedly; then the clock source stops."""
    script = {
        64: lambda at: events.SetTempo(time=at, source="test", tempo=60.0),
        192: lambda at: events.SetTempo(time=at, source="test", tempo=180.0),
        320: lambda at: events.ScaleTempo(time=at, source="test", factor=0.5),
        420: lambda at: events.ScaleTempo(time=at, source="test", factor=2.0),
        430: lambda at: events.One(time=at, source="test"),
        470: lambda at: events.SetTempo(time=at, source="test", tempo=60.0),
        500: lambda at: events.SetTempo(time=at, source="test", tempo=180.0),
        540: lambda at: events.SourceChanged(time=at, source="midi", state="stopped"),
        600: lambda at: events.PlaceElement(time=at, source="test", kind="attract", points=((3.0, 1.0),)),
    }
    recorder = MotionRecorder(show)
    tempi = []

    def act(tick):
        tempi.append(show.timeline.tempo)
        if tick in script:
            show.apply(script[tick](show.time))

    recorder.run(13.0, act)
    assert min(tempi) < 70.0
    assert max(tempi) > 170.0
    recorder.check_all()


@pytest.mark.long
def test_motion_holds_when_500_attractors_change_each_tick(show):
    chance = np.random.default_rng(1)
    recorder = MotionRecorder(show)
    recorder.run(1.0)

    def act(tick):
        for phone, (x, z) in enumerate(chance.uniform(-20.0, 20.0, (500, 2)).tolist()):
            show.apply(
                events.PlaceElement(
                    time=show.time,
                    source=f"phone {phone}",
                    kind="attract",
                    points=((x, z),),
                    measures=1.0,
                    drag=True,
                    strength=5.0,
                )
            )

    recorder.run(2.5, act)
    recorder.run(3.0)
    recorder.check_all()


@pytest.mark.long
def test_motion_holds_when_dancers_leave_mid_step_and_enter(show):
    """Leaving dancers walk to a gate and disappear; other dancers are not disturbed."""
    recorder = MotionRecorder(show)
    recorder.run(1.3)
    show.apply(events.PlaceElement(time=show.time, source="test", kind="attract", points=((-2.0, 0.0),)))
    show.apply(events.Leave(time=show.time, source="test", dancers="3 + 7"))
    recorder.run(0.7)
    show.apply(events.Enter(time=show.time, source="test", count=2))
    recorder.run(14.0)
    gone, new = [2, 6], [12, 13]
    assert not recorder.there[-1][gone].any()
    assert recorder.there[-1][new].all()
    staying = [dancer for dancer in range(12) if dancer not in gone]
    recorder.check_all(staying=staying)


@pytest.mark.long
def test_dancers_stay_inside_closing_walls(show):
    """Walls move inward while all dance: each dancer ends between them."""
    recorder = MotionRecorder(show)
    recorder.run(1.0)

    def act(tick):
        x = 4.5 - 1.5 * min((tick - 64) / 320.0, 1.0)
        for name, side in (("left", -x), ("right", x)):
            show.apply(events.PlaceWall(time=show.time, source="test", name=name, x=side, z=-3.0, x2=side, z2=3.0))

    recorder.run(9.0, act)
    recorder.check_all()
    ends = recorder.positions[-1][recorder.there[-1], 0, 0]
    assert np.abs(ends).max() < 3.0 + BODY


@pytest.mark.long
def test_dancers_are_not_corrected_through_walls_or_into_obstacles(loaded):
    """Obedient dancers move to and fro past both; the control run makes corrections blind to them."""
    depths = []
    for blind in (False, True):
        show = assemble(loaded.patch, loaded.graph, seed=7)
        if blind:
            show.scheduler.root_correction.path_separation._surroundings = None
        show.variation.set(OBEDIENCE, 0, 1.0)
        recorder = MotionRecorder(show)
        recorder.run(1.0)
        show.apply(events.PlaceObstacle(time=show.time, source="test", name="box", x=0.0, z=0.0, radius=0.7))
        show.apply(events.PlaceWall(time=show.time, source="test", name="wall", x=-2.0, z=-2.5, x2=-2.0, z2=0.5))
        recorder.run(4.0)
        begun = len(recorder.positions)
        for x, z in ((3.0, 1.0), (-3.5, -1.0), (3.0, 0.3), (-3.5, 1.0)):
            show.apply(
                events.PlaceElement(time=show.time, source="test", kind="attract", points=((x, z),), measures=2.0)
            )
            recorder.run(4.4)
        hips = np.array(recorder.positions)[begun:, :12, 0][..., (0, 2)]
        into_box = 0.7 + 0.25 - np.hypot(*np.moveaxis(hips, -1, 0))
        beside = (hips[..., 1] > -2.5) & (hips[..., 1] < 0.5)
        into_wall = np.where(beside, 0.25 - np.abs(hips[..., 0] + 2.0), 0.0)
        depths.append((np.maximum(into_box, 0.0).mean(), np.maximum(into_wall, 0.0).mean()))
        if not blind:
            recorder.check_all()
            left = hips[..., 0] < -2.0
            assert not ((left[1:] != left[:-1]) & beside[1:]).any()
            assert (into_box > 0.05).mean() < 0.005
    assert (np.array(depths[0]) < 0.6 * np.array(depths[1])).all()


def resize_stage(show, width, depth):
    return show.apply(events.SetStage(time=show.time, source="test", width=width, depth=depth))


@mostly_long("formation", [False, True], quick=[])
def test_dancers_walk_inside_when_stage_shrinks(show, formation):
    """Dancers outside walk in with planted feet, and dancers that are inside stay inside."""
    recorder = MotionRecorder(show)
    show.apply(events.PlaceElement(time=0.0, source="test", kind="spread"))
    if formation:
        show.apply(events.Evolve(time=0.0, source="test", formation="circle", measures=2.0))
    recorder.run(6.0)
    half = np.array([2.5, 1.8])
    assert np.count_nonzero(recorder.beyond(half)[-1][recorder.there[-1]] > 0.3) >= 5
    assert resize_stage(show, *(2.0 * half))
    begun = len(recorder.positions)
    borders = []
    recorder.run(13.0, lambda tick: borders.append(show.motion.stage_area.border.copy()))
    recorder.check_motion()
    steps = np.abs(np.diff(borders, axis=0)).max(axis=1)
    assert steps.max() < 1.0 * TICK  # m/s: it comes gently
    np.testing.assert_array_equal(borders[-1], half)
    arrived = begun + int((steps > 0.0).nonzero()[0].max()) + 2
    there = recorder.there[-1]
    inside = np.maximum.accumulate(recorder.beyond(half)[arrived:, there] <= 0.0, axis=0)
    assert inside[-1].all()
    assert recorder.beyond(half)[arrived:, there][inside].max() < BODY
    assert recorder.beyond(half)[begun + round(8.0 / TICK) :, there].max() < BODY
    assert (np.abs(show.state.position[there]) <= half + 1e-4).all()


@pytest.mark.long
def test_motion_holds_when_stage_size_changes_repeatedly(show):
    """Sizes change faster than walking speed: all dancers stay within the largest of them."""
    chance, recorder = np.random.default_rng(4), MotionRecorder(show)
    show.apply(events.PlaceElement(time=0.0, source="test", kind="spread", measures=16.0))

    def act(tick):
        if tick % 16 == 0:
            assert resize_stage(show, *(float(v) for v in chance.uniform((4.0, 3.0), (12.9, 9.9))))

    recorder.run(10.0, act)
    recorder.check_motion()
    assert recorder.beyond(show.motion.stage_area.largest)[np.array(recorder.there)].max() < BODY


@pytest.mark.long
def test_resize_is_deterministic_and_refused_sizes_change_nothing(loaded):
    """Too large, too narrow, no room for all: refused and counted, without effect on the state."""
    shows = [assemble(loaded.patch, loaded.graph) for _ in range(3)]
    for tick in range(1, 400):
        for number, show in enumerate(shows):
            if tick == 100 and number < 2:
                assert resize_stage(show, 6.0, 4.0)
            if tick == 150 and number == 0:
                for size in ((13.1, 6.0), (9.0, 10.1), (1.9, 6.0), (3.0, 3.0), (math.nan, 5.0), (5.0, math.inf)):
                    assert not resize_stage(show, *size)
            show.tick(tick * TICK)
    assert shows[0].refusals.count == 6
    assert "stage cannot be" in shows[0].refusals.last_reason
    assert shows[0].state_hash() == shows[1].state_hash() != shows[2].state_hash()


def test_stage_can_return_to_patch_size(show):
    assert resize_stage(show, 5.0, 4.0)
    assert resize_stage(show, 9.0, 6.0)
    np.testing.assert_array_equal(show.motion.stage_area.half, [4.5, 3.0])
    assert show.motion.stage_area.fit_size is None
    assert [gate.x for gate in show.motion.gates][:2] == [-4.5, 4.5]


@pytest.mark.long
def test_motion_holds_at_slowest_and_fastest_tempo(loaded):
    """Planted feet hold at the tempo limits, 40 and 240 bpm."""
    for tempo in (40.0, 240.0):
        show = assemble(loaded.patch, loaded.graph, tempo=tempo)
        recorder = MotionRecorder(show)
        show.apply(events.PlaceElement(time=0.0, source="test", kind="attract", points=((3.0, -2.0),), measures=2.0))
        recorder.run(5.0)
        assert math.isclose(show.timeline.tempo, tempo, rel_tol=1e-6)
        recorder.check_all()
