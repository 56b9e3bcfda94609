"""Garments on bodies that dance: lengths, contact, restart, pictures between ticks, and equal bits."""

import numpy as np
import pytest

from live.base.row_ranges import SerialRunner, row_runner
from live.clock.ticks import TICK
from live.motion.cloth.garment_catalogue import PATTERNS
from live.motion.cloth.pattern import LONGEST
from live.motion.skeleton import SKELETON
from live.render.body.body_mesh import FINE, build_body
from live.render.body.body_variants import parts_of
from live.render.body.implicit_surface import Shape
from live.show.stages.row_threads import row_threads
from tests.fixtures.mostly_long import mostly_long
from tests.motion.cloth.cloth_bodies import STILL, dressed, grid, posed, skinned, stretch, wild_dance
from tests.render.poses import REST, SIT

DANCERS = 8
TICKS = 256


@pytest.fixture(scope="module")
def dance():
    return wild_dance(TICKS, DANCERS)


def danced(batch, dance, ticks=TICKS, substeps=3):
    for tick in range(ticks):
        batch.tick(dance[0][tick], dance[1][tick], STILL, substeps, TICK)
    return batch


@mostly_long("name", PATTERNS, quick=[5, 6, 8])
def test_nothing_is_stretched_by_more_than_five_percent(name, dance):
    """Pose to pose in a third of a second, spinning, travelling and jumping: along columns always, and with hardly an
    exception along the rows of cloth."""
    batch, down, along = dressed(name, DANCERS), [], []
    for tick in range(TICKS):
        batch.tick(dance[0][tick], dance[1][tick], STILL, 3, TICK)
        if tick % 8 == 7:
            one = stretch(batch, grid(batch, dance[0][tick], dance[1][tick]))
            down.append(one[0]), along.append(one[1])
    assert np.max(down) <= LONGEST - 1.0 + 1e-3 <= 0.05
    if batch.compiled.pattern.kind == "cloth":
        assert np.percentile(np.concatenate(along), 99.9) < 0.05
        assert np.max(along) < 0.12


@mostly_long("body", ["dancer", "round", "child"], quick=[0])
@mostly_long("name", ["skirt", "long skirt", "long hair", "ponytail"], quick=[2])
def test_nothing_hangs_inside_the_body(name, body):
    """In the rest pose the implicit surface of the body is known exactly: whoever turns on the spot and stops has no
    cloth deeper than 5 mm in it."""
    batch, shape = dressed(name, body=body), Shape(parts_of(body))
    for tick in range(200):
        angle = 150.0 * np.sin(min(tick, 150) * 0.03)
        position, rotation = posed(REST, heading_deg=angle)
        batch.tick(position, rotation, STILL, 3, TICK)
        if tick % 20 == 19:
            turn = np.radians(angle)
            points = grid(batch, position, rotation)[0, batch.compiled.pattern.pinned_rows :].reshape(-1, 3)
            points = points.astype(np.float64) - [0.0, float(position[0, 0, 1]) - 0.935, 0.0]
            c, s = np.cos(turn), np.sin(turn)
            own = np.stack([c * points[:, 0] - s * points[:, 2], points[:, 1], s * points[:, 0] + c * points[:, 2]], 1)
            depth = shape.distance(own)
            assert depth.min() > -0.005, (tick, depth.min())


@pytest.mark.long
def test_skirt_stays_outside_of_a_body_that_dances(dance):
    """Against the skinned mesh: hardly a particle is more than 5 mm behind the skin."""
    batch, mesh = dressed("skirt", DANCERS), build_body(FINE)
    depth = []
    for tick in range(TICKS):
        batch.tick(dance[0][tick], dance[1][tick], STILL, 3, TICK)
        if tick % 32 == 31:
            places = grid(batch, dance[0][tick], dance[1][tick])[:, 1:]
            for dancer in range(0, DANCERS, 3):
                skin, normal = skinned(mesh, dance[0][tick][dancer], dance[1][tick][dancer])
                for point in places[dancer].reshape(-1, 3):
                    away = np.linalg.norm(skin - point, axis=1)
                    at = int(away.argmin())
                    if away[at] < 0.06:
                        depth.append(float((point - skin[at]) @ normal[at]))
    assert np.mean(np.array(depth) < -0.005) < 0.03


@pytest.mark.long
def test_spinning_flares_a_skirt_and_it_swings_on_when_the_dancer_stops():
    batch = dressed("skirt")
    hem = []
    for tick in range(360):
        angle = 360.0 * 1.5 * min(max(tick - 100, 0), 130) * TICK
        position, rotation = posed(heading_deg=angle)
        batch.tick(position, rotation, STILL, 3, TICK)
        hem.append(grid(batch, position, rotation)[0, -1])
    height = [float(one[:, 1].mean()) for one in hem]
    assert height[225] > height[95] + 0.06  # it flares
    swing = np.linalg.norm(hem[240] - hem[232], axis=1).mean()
    calm = np.linalg.norm(hem[358] - hem[350], axis=1).mean()
    assert swing > 0.05 > calm  # it goes on when she has stopped, then comes to rest
    assert abs(height[-1] - height[95]) < 0.08


@mostly_long("name", ["skirt", "long skirt"], quick=[0])
def test_skirt_does_not_tangle_when_a_turn_stops(name):
    """Two turns a second, up and down, then a stop: around the middle of each row neighbours stay in order, so no
    fold has passed another one."""
    batch, least = dressed(name), []
    for tick in range(220):
        spun = min(tick, 100) * TICK
        position, rotation = posed(heading_deg=720.0 * spun, lift=0.3 * np.sin(9.0 * spun))
        batch.tick(position, rotation, STILL, 3, TICK)
        if tick > 90 and tick % 4 == 0:
            own = grid(batch, position, rotation)[0].astype(np.float64)
            own -= own.mean(axis=1, keepdims=True)
            parts = np.cross(own, np.roll(own, -1, axis=1))
            axis = parts.sum(axis=1, keepdims=True)
            least.append(float(((parts * axis).sum(-1) / np.linalg.norm(axis, axis=-1)).min()))
    assert min(least) > 0.0


def turns_around(rings, point, axis):
    """How often closed rows (rows, columns, 3) go around a line through a point, as seen along it."""
    across = np.cross(axis, (0.3, 0.5, 0.8))
    across /= np.linalg.norm(across)
    own = rings.astype(np.float64) - point
    angle = np.arctan2(own @ np.cross(axis, across), own @ across)
    step = np.roll(angle, -1, axis=1) - angle
    return np.round(((step + np.pi) % (2.0 * np.pi) - np.pi).sum(axis=1) / (2.0 * np.pi))


@pytest.mark.long
def test_sleeve_stays_around_its_arm(dance):
    """Of the rows that hang on the forearm, hardly one has let it through, however fast it moves."""
    batch, around = dressed("left sleeve", DANCERS), []
    elbow, wrist = SKELETON.index("leftLowerArm"), SKELETON.index("leftHand")
    for tick in range(TICKS):
        batch.tick(dance[0][tick], dance[1][tick], STILL, 3, TICK)
        for who in range(DANCERS if tick % 8 == 7 else 0):
            places = dance[0][tick][who].astype(np.float64)
            axis = (places[wrist] - places[elbow]) / np.linalg.norm(places[wrist] - places[elbow])
            around.append(turns_around(grid(batch, dance[0][tick], dance[1][tick])[who, 1:4], places[elbow], axis))
    assert np.mean(np.array(around) == 1.0) > 0.85


@pytest.mark.parametrize("name", ["skirt", "long skirt"])
def test_who_sits_begins_with_both_thighs_in_the_skirt(name):
    batch = dressed(name)
    position, rotation = posed(SIT)
    for _ in range(30):
        batch.tick(position, rotation, STILL, 3, TICK)
    places = grid(batch, position, rotation)[0]
    for side in ("left", "right"):
        hip, knee = (
            position[0, SKELETON.index(f"{side}{part}")].astype(np.float64) for part in ("UpperLeg", "LowerLeg")
        )
        axis = (knee - hip) / np.linalg.norm(knee - hip)
        assert (turns_around(places[3:5], 0.5 * (hip + knee), axis) == -1.0).all()


@pytest.mark.long
def test_threads_do_not_change_a_bit(dance):
    one, many = dressed("skirt", 24), dressed("skirt", 24)
    crowd = tuple(np.concatenate([part] * 3, axis=1) for part in dance)
    with row_runner(SerialRunner()):
        danced(one, crowd, 60)
    with row_threads(2):
        danced(many, crowd, 60)
    assert one.position.tobytes() == many.position.tobytes()
    assert one.velocity.tobytes() == many.velocity.tobytes()


def test_a_garment_does_not_depend_on_who_else_wears_one(dance):
    alone, among = dressed("skirt", 1), dressed("skirt", DANCERS)
    danced(alone, (dance[0][:, :1].copy(), dance[1][:, :1].copy()), 80)
    danced(among, dance, 80)
    assert np.array_equal(alone.position[0, :, :, 0], among.position[0, :, :, 0])


def test_who_wears_it_keeps_its_state_when_others_come_and_go(dance):
    batch = danced(dressed("skirt", DANCERS), dance, 60)
    kept = batch.position[0, :, :, 5].copy()
    sections = batch._sections[0]
    batch.wear(np.array([1, 5], np.int32), [sections, sections])
    assert np.array_equal(batch.position[0, :, :, 1], kept)
    assert not batch.fresh[0, :2].any()
    batch.wear(np.array([3, 5], np.int32), [sections, sections])
    assert batch.fresh[0, 0] == 1
    assert batch.fresh[0, 1] == 0


def test_after_a_stall_it_begins_as_it_hangs(dance):
    """Ten seconds later somewhere else: no particle is thrown, nothing is torn."""
    batch = danced(dressed("skirt", DANCERS), dance, 100)
    position, rotation = posed(place=(6.0, -3.0), count=DANCERS)
    batch.restart()
    for _ in range(30):
        batch.tick(position, rotation, STILL, 3, TICK)
        places = grid(batch, position, rotation)
        assert np.abs(places[..., 0] - 6.0).max() < 0.9
        assert np.abs(batch.velocity).max() < 4.0
        assert stretch(batch, places)[0].max() < 0.05


def test_without_a_restart_a_jump_of_ten_metres_does_not_tear_it_either(dance):
    batch = danced(dressed("skirt", DANCERS), dance, 40)
    position, rotation = posed(place=(10.0, 0.0), count=DANCERS)
    for _ in range(3):
        batch.tick(position, rotation, STILL, 3, TICK)
    assert stretch(batch, grid(batch, position, rotation))[0].max() < 0.05


def test_a_number_that_is_not_finite_begins_anew(dance):
    batch = danced(dressed("skirt", DANCERS), dance, 20)
    batch.velocity[0, 1, 50, 2] = np.nan
    batch.tick(dance[0][20], dance[1][20], STILL, 3, TICK)
    assert batch.fresh[0].tolist() == [0, 0, 1, 0, 0, 0, 0, 0]
    places = grid(batch, dance[0][20], dance[1][20])
    assert np.isfinite(places).all()  # it is drawn as skin
    batch.tick(dance[0][21], dance[1][21], STILL, 3, TICK)
    assert not batch.fresh.any()
    assert np.isfinite(batch.position).all()


@pytest.mark.long
def test_picture_between_ticks_carries_it_with_the_body():
    """A dancer who glides at 2 m/s: half a tick later the garment is where the body is, and its shape is the same."""
    batch = dressed("skirt")
    for tick in range(200):
        position, rotation = posed(place=(2.0 * tick * TICK - 3.0, 0.0))
        batch.tick(position, rotation, STILL, 3, TICK)
    now = grid(batch, position, rotation)
    later, _ = posed(place=(2.0 * (199 + 0.5) * TICK - 3.0, 0.0))
    seen = grid(batch, later, rotation, age=0.5 * TICK)
    moved = seen - now - np.array([TICK, 0.0, 0.0], np.float32)
    assert np.abs(moved).max() < 4e-3
    assert np.abs(moved[:, 0]).max() < 1e-5  # the waistband exactly


def test_picture_changes_nothing(dance):
    batch = danced(dressed("skirt", DANCERS), dance, 30)
    before = batch.position.tobytes() + batch.velocity.tobytes() + batch.fresh.tobytes()
    grid(batch, dance[0][30], dance[1][30], age=0.01)
    grid(batch, dance[0][30], dance[1][30], skinned=True)
    assert before == batch.position.tobytes() + batch.velocity.tobytes() + batch.fresh.tobytes()


def test_nothing_is_below_the_floor(dance):
    batch = dressed("left ribbon", DANCERS)
    for tick in range(128):
        batch.tick(dance[0][tick], dance[1][tick], STILL, 3, TICK)
        assert grid(batch, dance[0][tick], dance[1][tick])[..., 1].min() > 0.0


def test_wind_blows_hair_its_way():
    batch = dressed("long hair")
    position, rotation = posed()
    tips = []
    for wind in (np.zeros(3, np.float32), np.array([6.0, 0.0, 0.0], np.float32)):
        batch.restart()
        for _ in range(150):
            batch.tick(position, rotation, wind, 3, TICK)
        tips.append(grid(batch, position, rotation)[0, -1, :, 0].mean())
    assert tips[1] > tips[0] + 0.04


@pytest.mark.long
def test_heavier_cloth_flares_less():
    hems = []
    for fabric in ("tulle", "wool"):
        batch = dressed("skirt", fabric=fabric)
        for tick in range(100):
            position, rotation = posed(heading_deg=360.0 * tick * TICK)
            batch.tick(position, rotation, STILL, 3, TICK)
        hems.append(float(grid(batch, position, rotation)[0, -1, :, 1].mean()))
    assert hems[0] != pytest.approx(hems[1], abs=0.01)
