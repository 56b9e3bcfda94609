"""Who has whose name, what is predicted, and one body from two cameras; landmarks are made from known poses."""

from typing import cast

import numpy as np
import numpy.typing as npt
import pytest

from live.control.camera.performers import FREE_AFTER_S, HARDLY_SEEN_S, Performers, Sighting
from live.motion.capture.camera_view import CameraView
from live.motion.capture.landmarks import Landmarks
from live.motion.capture.packed_pose import unpack_pose
from tests.motion.capture.made_landmarks import RATE, look_at, seen, step_clip, truth

Float64 = npt.NDArray[np.float64]
FRONT = look_at((0.0, 1.5, 6.0), (0.0, 0.9, 0.0))
SIDE = look_at((6.0, 1.5, 1.0), (0.0, 0.9, 0.0))


@pytest.fixture(scope="module")
def places() -> Float64:
    """Landmarks of a dance, (T, 33, 3) [m]."""
    return cast("Float64", truth(step_clip("", "groove"))[1])


def at(places: Float64, frame: int, x: float, view: CameraView, *, time: float | None = None) -> Landmarks:
    """What `view` sees of the dance at a frame, danced at x [m]."""
    here = places[frame % len(places)].copy()
    here[:, 0] += x - here[[23, 24], 0].mean()
    return seen(here, view, frame / RATE if time is None else time, np.random.default_rng(frame))


def test_names_are_given_in_the_order_of_appearance(places: Float64) -> None:
    performers = Performers(["anna", "ben"])
    first = performers.update(0, FRONT, [Sighting(7, at(places, 0, -1.0, FRONT))], 0.0)
    both = performers.update(
        0, FRONT, [Sighting(7, at(places, 1, -1.0, FRONT)), Sighting(9, at(places, 1, 1.0, FRONT))], 1 / RATE
    )
    assert [each.name for each in first] == ["anna"]
    assert [each.name for each in both] == ["anna", "ben"]
    third = performers.update(0, FRONT, [Sighting(11, at(places, 2, 0.0, FRONT))], 2 / RATE)
    assert third == []
    assert performers.without_name == 1


def test_places_are_those_on_the_stage(places: Float64) -> None:
    performers = Performers(["anna", "ben"])
    for frame in range(30):
        told = performers.update(
            0, FRONT,
            [Sighting(1, at(places, frame, -1.0, FRONT)), Sighting(2, at(places, frame, 1.2, FRONT))],
            frame / RATE,
        )  # fmt: skip
    found = {each.name: float(unpack_pose(each.packed)[0][0]) for each in told}
    assert found == {"anna": pytest.approx(-1.0, abs=0.12), "ben": pytest.approx(1.2, abs=0.12)}


def test_a_name_is_free_when_its_owner_has_been_away_for_long(places: Float64) -> None:
    performers = Performers(["anna"])
    for frame in range(45):
        performers.update(0, FRONT, [Sighting(1, at(places, frame, 0.0, FRONT))], frame / RATE)
    soon = 44 / RATE + FREE_AFTER_S - 1.0
    assert performers.update(0, FRONT, [Sighting(2, at(places, 0, 0.0, FRONT, time=soon))], soon) == []
    late = 44 / RATE + FREE_AFTER_S + 1.0
    (told,) = performers.update(0, FRONT, [Sighting(3, at(places, 0, 0.0, FRONT, time=late))], late)
    assert told.name == "anna"


def test_who_was_hardly_seen_does_not_keep_a_name(places: Float64) -> None:
    performers = Performers(["anna"])
    performers.update(0, FRONT, [Sighting(1, at(places, 0, 0.0, FRONT))], 0.0)
    soon, late = 0.5 * HARDLY_SEEN_S, HARDLY_SEEN_S + 0.1
    assert performers.update(0, FRONT, [Sighting(2, at(places, 0, 0.0, FRONT, time=soon))], soon) == []
    (told,) = performers.update(0, FRONT, [Sighting(2, at(places, 0, 0.0, FRONT, time=late))], late)
    assert told.name == "anna"


def test_people_off_the_stage_are_no_performers(places: Float64) -> None:
    performers = Performers(["anna"], (2.0, 2.0))
    assert performers.update(0, FRONT, [Sighting(1, at(places, 0, 3.5, FRONT))], 0.0) == []
    assert performers.outside == 1
    (told,) = performers.update(0, FRONT, [Sighting(2, at(places, 1, 0.5, FRONT))], 1 / RATE)
    assert told.name == "anna"


def test_a_pose_is_of_the_moment_at_which_it_is_shown(places: Float64) -> None:
    performers = Performers(["anna"])
    shown = []
    for frame in range(60):
        jitter = 0.01 * (frame % 3)
        (told,) = performers.update(
            0, FRONT, [Sighting(1, at(places, frame, 0.0, FRONT))], frame / RATE + 0.05 + jitter
        )
        shown.append(told.time - told.captured)
    assert shown[-1] == pytest.approx(0.06, abs=0.015)
    assert np.ptp(shown[30:]) < 0.01 + 1e-9, "the jitter of the work is not that of the dance"
    assert performers.delay(0) == pytest.approx(0.06, abs=0.005)


@pytest.mark.long
def test_two_cameras_see_one_person_and_better_than_one(places: Float64) -> None:
    errors: dict[str, list[float]] = {"both": [], "front": []}
    both, front = Performers(["anna", "ben"]), Performers(["anna", "ben"])
    for frame in range(90):
        time = frame / RATE
        told = both.update(0, FRONT, [Sighting(1, at(places, frame, 0.0, FRONT))], time)
        told = (
            both.update(1, SIDE, [Sighting(5, at(places, frame, 0.0, SIDE, time=time + 0.005))], time + 0.005) or told
        )
        alone = front.update(0, FRONT, [Sighting(1, at(places, frame, 0.0, FRONT))], time)
        assert {each.name for each in told} == {"anna"}
        if frame > 30:
            here = places[frame % len(places)]
            z = float(here[[23, 24], 2].mean())
            for name, pose in (("both", told[0]), ("front", alone[0])):
                errors[name].append(abs(float(unpack_pose(pose.packed)[0][2]) - z))
    assert np.mean(errors["both"]) < np.mean(errors["front"])


def test_the_second_camera_keeps_her_when_the_first_loses_her(places: Float64) -> None:
    performers = Performers(["anna"])
    names = []
    for frame in range(60):
        time = frame / RATE
        told = [] if frame > 30 else performers.update(0, FRONT, [Sighting(1, at(places, frame, 0.0, FRONT))], time)
        told += performers.update(1, SIDE, [Sighting(5, at(places, frame, 0.0, SIDE, time=time + 0.004))], time + 0.01)
        names.append({each.name for each in told})
    assert names == [{"anna"}] * 60


def test_two_performers_are_exchanged(places: Float64) -> None:
    performers = Performers(["anna", "ben"])
    sightings = [Sighting(1, at(places, 0, -1.0, FRONT)), Sighting(2, at(places, 0, 1.0, FRONT))]
    performers.update(0, FRONT, sightings, 0.0)
    assert performers.exchange("anna", "ben")
    assert not performers.exchange("anna", "carla")
    again = [Sighting(1, at(places, 1, -1.0, FRONT)), Sighting(2, at(places, 1, 1.0, FRONT))]
    assert [each.name for each in performers.update(0, FRONT, again, 1 / RATE)] == ["ben", "anna"]


def test_another_patch_keeps_the_names_that_it_has_too(places: Float64) -> None:
    performers = Performers(["anna", "ben"])
    sightings = [Sighting(1, at(places, 0, -1.0, FRONT)), Sighting(2, at(places, 0, 1.0, FRONT))]
    performers.update(0, FRONT, sightings, 0.0)
    performers.rename(["carla", "ben"])
    again = [Sighting(2, at(places, 1, 1.0, FRONT)), Sighting(1, at(places, 1, -1.0, FRONT))]
    assert [each.name for each in performers.update(0, FRONT, again, 1 / RATE)] == ["ben", "carla"]


def test_a_phone_says_whom_it_sees(places: Float64) -> None:
    performers = Performers(["anna", "ben"])
    (told,) = performers.update_named(1000, "ben", at(places, 0, 0.0, FRONT), 0.1)
    assert told.name == "ben"
    (told,) = performers.update_named(1000, "anna", at(places, 1, 0.0, FRONT), 0.1 + 1 / RATE)
    assert told.name == "anna"
    assert performers.update_named(1000, "carla", at(places, 2, 0.0, FRONT), 0.1 + 2 / RATE) == []
    assert performers.without_name == 1
