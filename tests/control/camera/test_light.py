"""What a camera says of the light, and figures on the screen."""

import numpy as np
import pytest

from live.control.camera.drawn_figures import COMPARED, DrawnFigures, square_to_quad
from live.control.camera.light import LightMeter
from live.control.camera.seen_person import Person
from tests.control.camera.painted_people import HEIGHT, WIDTH, Painted, PaintedPeople


def judge(meter: LightMeter, people: PaintedPeople, brightness: float = 1.0, background: int = 120) -> str:
    """Show one picture to the meter, with everybody in it."""
    picture = people.paint()
    empty = (picture == 120).all(axis=2)
    picture[empty] = background
    picture = (picture * brightness).astype(np.uint8)
    meter.look(picture)
    poses = [people.run(picture, each.region) for each in people.people]
    return meter.judge(picture, [Person(1, pose, 0.0, 0.0) for pose in poses])


def test_good_light_is_good() -> None:
    people = PaintedPeople()
    people.people = [Painted(300.0)]
    meter = LightMeter()
    assert [judge(meter, people) for _ in range(40)] == [""] * 40


def test_darkness_is_told_and_black_is_not_searched() -> None:
    people = PaintedPeople()
    people.people = [Painted(300.0)]
    meter = LightMeter()
    assert judge(meter, people, 0.1) == "dark"
    assert meter.look(np.zeros((HEIGHT, WIDTH, 3), np.uint8)) is False
    assert meter.look(np.full((HEIGHT, WIDTH, 3), 30, np.uint8)) is True


@pytest.mark.long
def test_a_strobe_is_told_and_a_slow_fade_is_not() -> None:
    people = PaintedPeople()
    people.people = [Painted(300.0)]
    meter = LightMeter()
    assert {judge(meter, people, 0.5 + 0.5 * frame / 60) for frame in range(60)} == {""}
    assert [judge(meter, people, frame % 2) for frame in range(40)][-1] == "strobe"


def test_a_dark_body_in_a_bright_picture_is_back_light() -> None:
    people = PaintedPeople()
    people.people = [Painted(300.0, colour=(20, 20, 22))]
    assert judge(LightMeter(), people, background=230) == "back light"
    assert judge(LightMeter(), people, background=50) == "", "a dark costume on a dark stage is none"


def test_changing_colours_on_the_body_are_a_projection() -> None:
    people = PaintedPeople()
    dancer = Painted(300.0)
    people.people = [dancer]
    meter, words = LightMeter(), []
    for frame in range(60):
        dancer.colour = (200, 40, 40) if frame < 10 else ((40, 200, 40), (40, 40, 220))[frame % 2]
        picture = people.paint()
        meter.look(picture)
        person = Person(1, people.run(picture, dancer.region), 0.0, 0.0)
        person.colours = _red()
        words.append(meter.judge(picture, [person]))
    assert words[9] == ""
    assert words[-1] == "projection on the body"


def _red() -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    from live.control.camera.costume import costume_colours

    people = PaintedPeople()
    people.people = [Painted(300.0)]
    pose = people.run(people.paint(), people.people[0].region)
    return costume_colours(people.paint(), pose.picture, pose.visibility)


# -- figures on the screen ---------------------------------------------------------------------------------------------

SCREEN = np.array(((0.2, 0.1), (0.8, 0.15), (0.78, 0.7), (0.22, 0.68)))


def test_the_homography_meets_the_corners() -> None:
    matrix = square_to_quad(SCREEN)
    square = np.array(((0.0, 0.0, 1.0), (1.0, 0.0, 1.0), (1.0, 1.0, 1.0), (0.0, 1.0, 1.0)))
    seen = square @ matrix.T
    assert seen[:, :2] / seen[:, 2:] == pytest.approx(SCREEN, abs=1e-9)


@pytest.mark.parametrize("wrong", [SCREEN[::-1], SCREEN[[0, 2, 1, 3]], np.zeros((4, 2))])
def test_corners_in_another_order_are_refused(wrong: np.ndarray[tuple[int, int], np.dtype[np.float64]]) -> None:
    with pytest.raises(ValueError, match="upper left"):
        square_to_quad(wrong)


def test_a_drawn_figure_is_no_person_and_a_person_beside_it_is_one() -> None:
    people = PaintedPeople()
    dancer = Painted(320.0, tall=150.0)
    people.people = [dancer]
    pose = people.run(people.paint(), dancer.region)
    matrix = np.linalg.inv(square_to_quad(SCREEN))
    joints = np.column_stack((dancer.landmarks[list(COMPARED)] / (WIDTH, HEIGHT), np.ones(12))) @ matrix.T
    joints = joints[:, :2] / joints[:, 2:]
    figures = DrawnFigures(SCREEN)
    assert not figures.shows(pose, WIDTH, HEIGHT)
    figures.draw(1.0, joints[None])
    assert figures.shows(pose, WIDTH, HEIGHT)
    figures.draw(1.1, np.add(joints, (0.3, 0.0))[None])
    assert figures.shows(pose, WIDTH, HEIGHT), "projector and camera are late: a figure of a moment ago counts"
    figures.draw(2.0, np.add(joints, (0.3, 0.0))[None])
    assert not figures.shows(pose, WIDTH, HEIGHT)
    figures.draw(2.1, np.zeros((0, 12, 2)))
    assert not figures.shows(pose, WIDTH, HEIGHT)


def test_a_person_in_another_pose_before_a_drawn_figure_is_seen() -> None:
    people = PaintedPeople()
    dancer = Painted(320.0, tall=150.0)
    people.people = [dancer]
    matrix = np.linalg.inv(square_to_quad(SCREEN))
    joints = np.column_stack((dancer.landmarks[list(COMPARED)] / (WIDTH, HEIGHT), np.ones(12))) @ matrix.T
    figures = DrawnFigures(SCREEN)
    figures.draw(1.0, (joints[:, :2] / joints[:, 2:])[None])
    dancer.tall, dancer.y = 220.0, 200.0  # nearer to the camera
    assert not figures.shows(people.run(people.paint(), dancer.region), WIDTH, HEIGHT)
