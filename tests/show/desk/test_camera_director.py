"""Tests of the camera director: framing by geometry, legible sides, cuts on phrases, take-over, bad stages, replays."""

import math

import numpy as np
import pytest

from live.base import picture_parameters as pp
from live.clock.ticks import TICK
from live.motion.skeleton import SKELETON
from live.render.camera import project_points
from live.show.desk.camera_directions import BEARINGS_DEG, DIRECTIONS, ELEVATIONS_DEG, Stand, ViewComparison
from live.show.desk.camera_framing import Framing
from live.show.desk.camera_kernels import HEIGHT, RADIUS, keep_clear
from live.show.desk.camera_shots import FULL, KINDS, TOTAL, WAIST
from live.show.state.snapshot import Snapshotter, restore
from tests.fixtures.mostly_long import mostly_long
from tests.show.desk.desk_show import DeskSession
from tests.show.desk.test_light_desk_state import LOADED

SIZE = (1600, 900)
HEAD = SKELETON.names.index("head")
FRAMING = Framing(16 / 9, np.array([6.0, 4.0]))
LIVELY = '[camera]\nmood = "lively"\n'


def camera_of(frame):
    flat = math.cos(frame.elevation)
    way = np.array([flat * math.sin(frame.bearing), math.sin(frame.elevation), flat * math.cos(frame.bearing)])
    eye = frame.target + frame.distance * way
    row = np.zeros(pp.ROW_SIZE)
    row[pp.EYE], row[pp.TARGET], row[pp.FIELD_OF_VIEW] = eye, frame.target, frame.field_of_view
    row[pp.ROLL + 3] = 1.0
    return pp.camera_from_row(row)


def box(camera, place, lowest=0.0):
    """Shares of the picture that bodies reach: left, top, right, bottom, by projection of their sides, heads, feet."""
    turn = np.linspace(0.0, math.tau, 72)
    ring = (place[:, None] + np.stack([np.cos(turn), np.sin(turn)], 1) * RADIUS).reshape(-1, 2)
    sides, ends = (
        project_points(camera, SIZE, np.concatenate([np.insert(flat, 1, y, axis=1) for y in (lowest, HEIGHT)])) / SIZE
        for flat in (ring, place)
    )
    return sides[:, 0].min(), ends[:, 1].min(), sides[:, 0].max(), ends[:, 1].max()


@pytest.mark.parametrize("width", [0.1, 3.0, 9.0, 60.0])
@pytest.mark.parametrize(("bearing", "elevation"), [(0.0, 0.1), (0.7, 0.3), (-1.1, 0.9)])
def test_formation_fills_the_picture_with_feet_and_heads_in(width, bearing, elevation):
    rng = np.random.default_rng(3)
    place = rng.uniform(-0.5, 0.5, (30, 2)) * [width, 0.6 * width]
    frame = FRAMING.fit(TOTAL, place, np.ones(30, np.bool_), bearing, elevation)
    left, top, right, bottom = box(camera_of(frame), place)
    assert 0.6 <= max(right - left, bottom - top) <= 0.8
    assert min(left, 1.0 - right) > 0.08
    assert 0.05 < top < bottom < 0.95
    assert FRAMING.stands(TOTAL, place, np.ones(30, np.bool_), frame)
    assert not FRAMING.stands(TOTAL, 1.4 * place + 0.1 * width + 0.5, np.ones(30, np.bool_), frame)


def test_near_shot_ends_at_its_height_and_leaves_headroom():
    place = np.array([[1.0, 2.0]])
    frame = FRAMING.fit(WAIST, place, np.ones(1, np.bool_), 0.2, 0.05)
    _, top, _, bottom = box(camera_of(frame), place, WAIST.lowest)
    assert top == pytest.approx(0.09, abs=0.02)
    assert bottom == pytest.approx(0.985, abs=0.02)


@pytest.mark.parametrize("kind", [FULL, WAIST])
def test_who_dances_low_is_framed_lower(kind):
    place, one = np.array([[1.0, 2.0]]), np.ones(1, np.bool_)
    frame = FRAMING.fit(kind, place, one, 0.2, 0.05, 1.4)
    head = project_points(camera_of(frame), SIZE, np.array([[1.0, 1.4, 2.0]]))[0] / SIZE
    assert head[1] == pytest.approx(0.09, abs=0.01)
    assert FRAMING.stands(kind, place, one, frame, 1.4)
    assert not FRAMING.stands(kind, place, one, frame)  # she has stood up


def test_empty_stage_is_framed_as_a_whole():
    frame = FRAMING.fit(TOTAL, np.zeros((3, 2)), np.zeros(3, np.bool_), 0.0, 0.3)
    corners = np.array([[-6, 0, -4], [6, 0, -4], [6, 0, 4], [-6, 0, 4]], float)
    where = project_points(camera_of(frame), SIZE, corners) / SIZE
    assert where.min() > 0.05
    assert where.max() < 0.95


def best(place, heading=None, chosen=None, subject=0):
    """Bearing and elevation [degrees] that are compared best."""
    count = len(place)
    subjects = np.zeros((4, count), np.bool_)
    subjects[0] = True
    if chosen is not None:
        subjects[1 if subject == 0 else subject, chosen] = True
    stand = Stand(np.asarray(place, float), np.zeros(count) if heading is None else heading, subjects[0], subjects)
    compared = ViewComparison(FRAMING, stand)
    compared.work(len(DIRECTIONS))
    assert compared.finished
    return np.degrees(DIRECTIONS[int(compared.score[subject].argmax())])


def test_line_is_seen_across_from_low():
    bearing, elevation = best([[x, 0.0] for x in np.linspace(-4, 4, 9)])
    assert abs(bearing) < 12
    assert elevation < 16


def test_column_and_diagonal_are_seen_from_where_they_spread():
    bearing, _ = best([[0.0, z] for z in np.linspace(-3, 3, 8)])
    assert abs(bearing) > 20
    bearing, _ = best([[-x, x] for x in np.linspace(-3, 3, 8)])  # from back right to front left
    assert bearing > -1e-6
    mirrored, _ = best([[x, x] for x in np.linspace(-3, 3, 8)])
    assert mirrored == pytest.approx(-bearing)


def test_circle_is_seen_from_higher_than_a_line():
    turn = np.linspace(0.0, math.tau, 13)[:-1]
    _, elevation = best(3.0 * np.stack([np.sin(turn), np.cos(turn)], 1))
    assert elevation > best([[x, 0.0] for x in np.linspace(-4, 4, 9)])[1]


def test_pair_is_seen_from_where_none_hides_the_other():
    bearing, elevation = best([[0.0, 0.4], [0.0, -0.4]], chosen=[0, 1], subject=3)
    assert abs(bearing) > 20 or elevation > 20


def test_soloist_behind_others_turns_the_camera():
    row = [[x, 1.0] for x in np.linspace(-1.5, 1.5, 5)]
    there = best([*row, [0.0, 0.0]], chosen=[5], subject=1)
    assert abs(there[0]) > 10 or there[1] > 8


def test_all_on_one_spot_and_a_thousand_are_framed():
    for place in (np.zeros((50, 2)), np.random.default_rng(1).uniform(-30, 30, (1000, 2))):
        frame = FRAMING.fit(TOTAL, place, np.ones(len(place), np.bool_), 0.3, 0.2)
        assert np.isfinite(frame.numbers).all()
        assert best(place) is not None


def test_eye_never_enters_a_body_or_the_floor():
    rng = np.random.default_rng(2)
    place = rng.uniform(-2, 2, (40, 2))
    there = rng.random(40) < 0.8
    for eye in rng.uniform(-3, 3, (200, 3)):
        keep_clear(eye, place, there, 1.1, 0.3)
        assert eye[1] >= 0.3
        near = np.hypot(*(place[there] - eye[[0, 2]]).T).min()
        assert near >= 1.1 - 1e-6 or eye[1] >= HEIGHT + 1.1 - 1e-6


# -- in a show ---------------------------------------------------------------------------------------------------------


def pictures(session, beats):
    """Each tick's eye, target and shot."""
    for _ in range(round(beats * 32)):
        session.run(ticks=1)
        row = session.desk.parameters.picture
        yield row[pp.EYE].copy(), row[pp.TARGET].copy(), session.desk.director


def joints(session):
    view = session.show.view()
    session.show.fill(view, session.ticks * TICK)
    return pp.camera_from_row(view.picture), view.joint_position[view.present & session.desk.director.chosen]


@pytest.mark.long
def test_top_is_that_of_the_highest_head_in_the_measure():
    session, highest = DeskSession(LIVELY).run(beats=8), 0.0
    subjects, view = session.desk.director._subjects, session.show.view()
    top = subjects.top(subjects.present())
    for _ in range(126):
        session.run(ticks=1)
        session.show.fill(view, session.ticks * TICK)
        highest = max(highest, float(view.joint_position[view.present, HEAD, 1].max()))
    assert top == pytest.approx(highest + 0.20, abs=0.03)


@mostly_long("mood", ["calm", "lively", "cinematic", "still"], quick=[])
def test_whole_show_is_framed_and_changes_on_phrases(mood):
    session, kinds, cuts = DeskSession(f'[camera]\nmood = "{mood}"\n'), {kind.name for kind in KINDS if kind.whole}, 0
    good, count, last = 0, 0, None
    for number, (eye, target, director) in enumerate(pictures(session, 128)):
        assert np.isfinite(eye).all()
        assert eye[1] >= 0.3
        if director.cuts > cuts:
            cuts = director.cuts
            within = session.show.danced_beats % 4
            assert within < 0.05  # on the first beat of a measure
            assert eye[2] > target[2]  # on the public's side of the line
        elif last is not None:
            assert np.linalg.norm(eye - last) < 0.25  # no jump without a cut
        last = eye
        if number % 32 == 0 and director.kind.name in kinds and director._moved >= director._length:
            camera, bodies = joints(session)
            where = project_points(camera, SIZE, bodies.reshape(-1, 3).astype(float)) / SIZE
            assert where[:, 1].max() < 1.0  # feet
            wide, high = where.max(axis=0) - where.min(axis=0)
            good, count = good + (0.55 <= max(wide, high) <= 0.85), count + 1
    assert good >= 0.95 * count > 10
    assert (cuts > 0) == (mood in ("lively", "cinematic"))


@pytest.mark.long
def test_show_without_camera_has_a_director_and_one_with_camera_has_none():
    assert DeskSession("", directed=True).run(1).desk.director.running
    assert not DeskSession("").run(1).desk.director.running
    assert DeskSession("[camera]\ndirector = true\n").run(1).desk.director.running


@mostly_long(
    "call",
    [("/dance/camera/eye", 3.0, 2.0, 9.0), ("/dance/camera/orbit", 0.1), ("/dance/camera", "side"),
     ("/dance/camera/follow", "front"), ("/dance/camera/field_of_view", 50.0)],
    ids=lambda call: call[0], quick=[3],
)  # fmt: skip
def test_touch_takes_the_camera_over_and_the_switch_gives_it_back_smoothly(call):
    session = DeskSession(LIVELY).run(6)
    before = session.desk.parameters.picture[pp.EYE].copy()
    session.run(ticks=1)
    assert session.say(*call), session.words
    session.run(ticks=1)
    assert not session.desk.director.running
    if call[0] not in ("/dance/camera/eye", "/dance/camera"):
        assert np.linalg.norm(session.desk.parameters.picture[pp.EYE] - before) < 0.2  # from where it is
    session.run(8)
    eye = session.desk.parameters.picture[pp.EYE].copy()
    assert session.say("/dance/camera/director", True), session.words
    eyes = np.array([eye, *(one for one, _, _ in pictures(session, 3.5))])
    assert session.desk.director.running
    assert np.linalg.norm(np.diff(eyes, axis=0), axis=1).max() < 0.5
    assert session.value("/dance/camera/orbit") == session.value("/dance/camera/following") == 0.0


def test_other_parameters_and_the_plan_leave_the_director_alone():
    session = DeskSession(LIVELY).run(1)
    session.say("/dance/light/level", 0.5)
    session.say("/dance/camera/plan", 0.4)
    session.say("/dance/camera/mood", 3.0)
    assert session.run(1).desk.director.running
    assert session.desk.director.mood.name == "cinematic"


@pytest.mark.long
def test_undo_of_a_touch_gives_the_camera_back():
    session = DeskSession(LIVELY).run(5)
    session.say("/dance/camera/eye", 3.0, 2.0, 9.0)
    session.run(4)
    session.say("/dance/undo")
    assert session.run(1).desk.director.running


def test_locked_camera_stands_and_says_so():
    session = DeskSession("[camera]\nlock = true\n").run(1)
    eye = session.desk.parameters.picture[pp.EYE].copy()
    assert not session.say("/dance/camera/director", True)
    assert "locked" in session.words
    session.run(16)
    assert (session.desk.parameters.picture[pp.EYE] == eye).all()
    assert any("locked" in line for line in session.desk.status_lines(0.0))
    assert session.desk.facts(0.0)["camera"]["locked"]


@pytest.mark.long
def test_only_dancer_is_shown_whole_and_an_empty_stage_too():
    session = DeskSession(LIVELY).run(1)
    assert session.say("/dance/leave", "front + back - 1"), session.words
    while np.count_nonzero(session.show.motion.present) > 1:
        assert session.run(4).ticks < 64 * 120
    session.run(16)
    camera, bodies = joints(session)
    where = project_points(camera, SIZE, bodies.reshape(-1, 3).astype(float)) / SIZE
    assert 0.5 < where[:, 1].max() - where[:, 1].min() < 0.85
    assert session.say("/dance/leave", "1"), session.words
    for eye, target, _ in pictures(session, 240):  # and then nobody is left
        assert np.isfinite([eye, target]).all()
    assert not session.show.motion.present.any()
    camera, _ = joints(session)
    floor = project_points(camera, SIZE, np.array([[x, 0.0, z] for x in (-6.0, 6.0) for z in (-4.0, 4.0)])) / SIZE
    assert floor.min() > 0.0
    assert floor.max() < 1.0


def test_soloist_of_the_patch_is_shown_near():
    session = DeskSession(LIVELY).run(1)
    stand = session.desk.director._subjects
    present = stand.present()
    session.say("/dance/spot/follow", "3", 1, 1.0)
    session.run(1)
    assert np.flatnonzero(stand.soloists(present)).tolist() == [2]
    frame = FRAMING.fit(FULL, stand.places(), stand.soloists(present), 0.0, 0.1)
    assert frame.distance < 6.0


def test_restored_show_has_the_same_pictures():
    session = DeskSession("", directed=True)
    session.say("/dance/camera/mood", 2.0)
    session.run(14.2)
    source = Snapshotter(session.show)
    while (taken := source.capture(session.ticks)) is None:
        session.run(ticks=1)
    data = taken.seal()
    there = DeskSession("", directed=True)
    there.show, there.ticks = restore(DIRECTED, data), session.ticks
    for one, other in zip(pictures(session, 40), pictures(there, 40), strict=True):
        assert (one[0] == other[0]).all()
        assert (one[1] == other[1]).all()
    assert there.show.state_hash() == session.show.state_hash()
    assert session.desk.director.cuts > 0


@pytest.mark.long
def test_pictures_between_ticks_go_on_with_the_camera():
    session = DeskSession(LIVELY).run(10)
    view = session.show.view()
    moved = 0
    for _ in range(600):
        cuts = session.desk.director.cuts
        session.run(ticks=1)
        session.show.fill(view, session.ticks * TICK + 0.5 * TICK)
        between = view.picture[pp.EYE].copy()
        here = session.desk.parameters.picture[pp.EYE].copy()
        session.run(ticks=1)
        there = session.desk.parameters.picture[pp.EYE]
        if session.desk.director.cuts == cuts and np.linalg.norm(there - here) > 0.005:
            moved += 1
            assert np.linalg.norm(between - 0.5 * (here + there)) < 0.3 * np.linalg.norm(there - here)
    assert moved > 5


DIRECTED = LOADED.__class__(LOADED.path, DeskSession("", directed=True).show.patch, LOADED.graph)


def test_directions_reach_from_the_front_to_the_sides():
    assert len(DIRECTIONS) == len(BEARINGS_DEG) * len(ELEVATIONS_DEG)
    assert np.abs(DIRECTIONS[:, 0]).max() < math.pi / 2
