"""Consistency checks between the arrays of an object, where kernels rely on matching sizes.

Each check runs after the types of all fields were checked.
"""

from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.agents.crowd.contact_kernels import CAPACITY
from live.agents.crowd.crowd_step import CrowdStepper
from live.agents.crowd.obstacles import Surroundings
from live.agents.crowd.passage_kernels import PASSAGE_COLUMNS, PASSAGES
from live.agents.elements import element_table_kernels
from live.agents.elements.element import Element
from live.agents.elements.element_table import GRID_SLOTS, ElementTable
from live.agents.evolutions.intention import Places
from live.agents.evolutions.planned_segment import PlannedSegment
from live.agents.evolutions.segment_start import PlannedMotion, SegmentStart
from live.agents.evolutions.trajectory import Locomotion
from live.base.element_kinds import FLOW_NAMES, KIND_COUNT, MAX_POINTS, MAX_VERTICES, OUTLINE_VERTICES
from live.motion.partner_live.hand_holds import LiveHandHolds
from live.motion.partner_live.stage_partner import LeaderReader
from live.motion.recognition.body_stream import BodyStream
from live.motion.recognition.example_follower import ExampleFollower
from live.motion.recognition.gesture_examples import ExampleBank, ExampleMatcher
from live.motion.recognition.gesture_kernels import FEATURES, MEASURES
from live.motion.recognition.movement import Movement
from live.motion.recognition.recognition_names import GESTURE_NAMES, LEVELS, MAX_MOMENTS, MIN_MOMENTS
from live.motion.skeleton import JOINT_COUNT
from live.show.capture.gesture_learning import Lesson
from live.show.capture.gestures import MAX_BACKGROUND, MAX_PIECES, Gestures, PerformerMovement
from live.show.capture.performer import CapturedPerformer
from live.show.capture.pose_buffer import CANON_CAPACITY, POSE_CAPACITY, PoseBuffer
from live.show.group.division import FREE, Division
from live.show.group.group_values import GroupValues
from live.show.score.subgroups import MAX_SUBGROUPS, Subgroups
from live.show.state.constants import attribute_at
from live.show.state.kind import MAX_MAGNITUDE

Array = npt.NDArray[Any]
_OF_READERS: Final = (
    "_x", "_x_height", "posterior", "_now", "_soon", "_feature", "_near_square", "_square", "_scratch", "_cost",
    "expected",
)  # fmt: skip


def advance(value: CrowdStepper) -> bool:
    """Whether agent and steering parameters are in range; only the stage may be infinite."""
    begin = 2 * attribute_at(value, "_agent_count")
    fixed: Array = attribute_at(value, "_fixed")
    stage, others = fixed[begin : begin + 2], np.delete(fixed, [begin, begin + 1])
    return bool((stage > 0.0).all() and np.abs(others).max() <= MAX_MAGNITUDE)


def element_table(value: ElementTable) -> bool:
    """Whether the rows hold valid indices of corners, grids and elements; only an element's end may be infinite."""
    rows: Array = attribute_at(value, "_all_rows")
    first, most = attribute_at(value, "_first"), attribute_at(value, "_capacity")
    others = np.delete(rows, element_table_kernels.END, axis=1)
    whole = not np.isnan(rows).any() and bool(np.abs(others).max(initial=0.0) <= MAX_MAGNITUDE)
    within = all(
        low <= rows[:, place].min(initial=0.0) and rows[:, place].max(initial=0.0) <= high
        for place, low, high in _ROWS_WITHIN
    )
    return whole and within and 0 <= first <= most and len(value) <= most == len(value.rows)


_ROWS_WITHIN: Final = (
    (element_table_kernels.KIND, 0, KIND_COUNT - 1),
    (element_table_kernels.CORNERS, 0, MAX_VERTICES),
    (element_table_kernels.OUTLINE, 0, OUTLINE_VERTICES),
    (element_table_kernels.FLOW_KIND, -1, max(FLOW_NAMES.values())),
    (element_table_kernels.SLOT, -1, GRID_SLOTS - 1),
    (element_table_kernels.TARGET_GROUP, -1, 63),
)


def element(value: Element) -> bool:
    """Whether kind, target group and number of points are in range."""
    return 0 <= value.kind < KIND_COUNT and -1 <= value.target_group < 64 and len(value.points) <= MAX_POINTS


def surroundings(value: Surroundings) -> bool:
    """Whether there is a name for each wall and obstacle, and no passage too many."""
    walls, obstacles, passages = value.flat[9 * CAPACITY : 9 * CAPACITY + 3].tolist()
    named = [walls, obstacles] == [len(value.wall_names), len(value.obstacle_names)] and passages in range(PASSAGES + 1)
    size = 9 * CAPACITY + 3 + PASSAGES * PASSAGE_COLUMNS
    return bool(named and max(walls, obstacles) <= CAPACITY and len(value.flat) == size)


def locomotion(value: Locomotion) -> bool:
    """Whether knots, times and turns are for the same number of dancers; it raises if not."""
    value.__post_init__()
    return True


def places(value: Places) -> bool:
    """Whether every slot has a heading."""
    count = len(value.slots)
    return value.slots.shape == (count, 2) and value.heading.shape == (count,) and len(value.marks) in (0, count)


def departure(value: SegmentStart) -> bool:
    """Whether every dancer has a position, heading, radius and words."""
    count = len(value.dancer_indices)
    return (
        value.dancer_indices.shape == value.heading.shape == value.radius.shape == (count,)
        and value.position.shape == (count, 2)
        and len(value.attributes) == count
    )


def journey(value: PlannedMotion) -> bool:
    """Whether every dancer with a slot has a trajectory."""
    return value.slot.shape == (value.locomotion.count,)


def motion(value: PlannedSegment) -> bool:
    """Whether every moving dancer has a trajectory."""
    count = len(value.dancers)
    ways = value.motion is None or value.motion.locomotion.count == count
    return value.dancers.shape == value.controlled.shape == (count,) and ways


def heard_poses(value: PoseBuffer) -> bool:
    """Whether there is one more pose than time stamps."""
    root, turned, stamp, count = value.arrays
    size = len(stamp)
    return (
        size in (POSE_CAPACITY, CANON_CAPACITY)
        and stamp.shape == (size, 2)
        and root.shape == (size + 1, 3)
        and turned.shape == (size + 1, JOINT_COUNT, 4)
        and count >= 0
    )


def captured(value: CapturedPerformer) -> bool:
    """Whether all arrays have a row for each dancer that shows this performer's poses."""
    count = len(value.rows)
    ones = (value.rows, value.delay, value.fade, value.turn_angle)
    place = attribute_at(value, "bounds.last_position")
    return all(array.shape == (count,) for array in ones) and value.offset.shape == place.shape == (count, 2)


def gesture_bank(value: ExampleBank) -> bool:
    """Whether each example has its moments, weights and threshold."""
    count, first = len(value.threshold), value.first
    return (
        value.moment.ndim == 2
        and value.moment.shape[1] == FEATURES
        and value.weight.shape == (count, FEATURES)
        and value.threshold.shape == (count,)
        and first.shape == (count + 1,)
        and first[0] == 0
        and first[-1] == len(value.moment)
        and bool((np.diff(first) > 0).all())
    )


def gesture_matcher(value: ExampleMatcher) -> bool:
    """Whether the sums have a value for each moment of each example."""
    count, moments = len(attribute_at(value, "_bank.threshold")), len(attribute_at(value, "_bank.moment"))
    memory, begun = attribute_at(value, "_memory"), attribute_at(value, "_begun")
    return (
        value.mean.shape == value.begun.shape == (count,)
        and memory.shape == (3, moments)
        and begun.shape == (2, moments)
    )


def gesture_examples(value: ExampleFollower) -> bool:
    """Whether each example has a gesture."""
    gesture, best = attribute_at(value, "_gesture"), attribute_at(value, "_best")
    each = ("_best", "_ended", "_usual", "limit", "_scale", "_told", "_least")
    return (
        gesture.shape == (len(attribute_at(value, "_bank.threshold")),)
        and attribute_at(value, "_matcher._bank") is attribute_at(value, "_bank")
        and best.ndim == 1
        and gesture.min(initial=0) >= 0
        and gesture.max(initial=-1) < len(best)
        and attribute_at(value, "_times").shape == (3, len(best))
        and all(attribute_at(value, name).shape == best.shape for name in each)
        and attribute_at(value, "_before").shape == (FEATURES,)
    )


def movement(value: Movement) -> bool:
    """Whether moments are counted from zero, and all arrays are a fresh one's."""
    names = ("level", "_signal", "_repeat", "_smooth", "_drift", "_rating")
    fresh = Movement()
    shapes = all(attribute_at(value, name).shape == attribute_at(fresh, name).shape for name in names)
    return shapes and attribute_at(value, "_count") >= 0 and attribute_at(value, "_steady") >= 0


def body_stream(value: BodyStream) -> bool:
    """Whether all arrays are those of one body."""
    joints = attribute_at(value, "_joint").shape == attribute_at(value, "_smooth").shape == (JOINT_COUNT, 3)
    return joints and value.measure.shape == (MEASURES,) and value.feature.shape == (FEATURES,) and value.count >= 0


def performer_movement(value: PerformerMovement) -> bool:
    """Whether the kept poses have their places, and each number its range."""
    hips, rotation = attribute_at(value, "_hips"), attribute_at(value, "_rotation")
    shapes = hips.shape == (MAX_MOMENTS, 3) and rotation.shape == (MAX_MOMENTS, JOINT_COUNT, 4)
    built_in = attribute_at(value, "built_in._inside"), attribute_at(value, "built_in._told")
    known = all(len(each) == len(GESTURE_NAMES) for each in built_in)
    return shapes and known and attribute_at(value, "_kept") >= 0 and len(value.ranges) == len(LEVELS)


def gesture_lesson(value: Lesson) -> bool:
    """Whether it has as many poses as an example and its background may have, or none."""
    count, moments = len(value.hips), len(value.hips) - value.background
    shapes = value.hips.shape == (count, 3) and value.rotation.shape == (count, JOINT_COUNT, 4)
    lengths = 0 <= value.background <= MAX_BACKGROUND and MIN_MOMENTS <= moments <= MAX_MOMENTS
    return shapes and (lengths or not (count or value.background))


def gestures(value: Gestures) -> bool:
    """Whether all numbers of gestures are those of names, and no more pieces are done than a lesson has."""
    names, whose, of = (attribute_at(value, name) for name in ("_names", "_performers", "_gesture"))
    followers = attribute_at(value, "_followers").values()
    numbers = [*of, *(number for each in followers for number in attribute_at(each, "examples._gesture").tolist())]
    pieces, lessons = attribute_at(value, "_pieces"), attribute_at(value, "_lessons")
    learning = 0 <= pieces <= MAX_PIECES and (bool(lessons) or not pieces) and attribute_at(value, "_clips_read") >= 0
    return learning and len(names) == len(whose) and all(0 <= number < len(names) for number in numbers)


def holding(value: LiveHandHolds) -> bool:
    """Whether all arrays have a row for each hand hold."""
    laid: list[tuple[int, ...]] = attribute_at(value, "_row_keys")
    if not hasattr(value, "_dancers"):
        return not laid
    who, hands, where, far = (attribute_at(value, name) for name in ("_dancers", "_hands", "_pose_rows", "_palm_table"))
    count, looked = len(laid), len(attribute_at(value, "_seen_dancers"))
    rows = (who, hands, where)
    within = where.min(initial=0) >= 0 and where.max(initial=-1) < looked
    return all(array.shape == (count, 2) for array in rows) and far.shape == (count, 6) and bool(within)


def division(value: Division) -> bool:
    """Whether the groups are parts, and every dancer's part exists."""
    groups = value.group_of[: value.group_count].tolist() == list(range(value.group_count))
    return groups and value.part.min(initial=0) >= 0 and bool((value.group_of[value.part] != FREE).all())


def group_values(value: GroupValues[Any]) -> bool:
    """Whether all masks are of the same dancers, and all values of one kind."""
    kinds = {type(each) for each in (*value.groups, *(own for _, own in value.own))}
    return len({mask.shape for mask, _ in value.own}) <= 1 and len(kinds) == 1


def subgroups(value: Subgroups) -> bool:
    """Whether every dancer's subgroup exists, and each has its dancers and a group."""
    everyone = (*value.active, *value.requested, *(each for row in value.written for each in row))
    count, groups = len(value.of_dancer), len(attribute_at(value, "_programs"))
    whole = all(each.chosen.shape == (count,) and 0 <= each.group < groups for each in everyone)
    rows = len(value.active) <= MAX_SUBGROUPS and value.of_dancer.max(initial=-1) < len(value.active)
    return whole and bool(rows) and all(len(row) == groups for row in value.written)


def read_leader(value: LeaderReader) -> bool:
    """Whether the filter has the same model and array sizes as that of its examples."""
    if value.style not in value.examples.filters:
        return False
    reader, like = value.partner.filter, value.examples.filters[value.style]
    same = reader.model is like.model and reader.units is like.units
    example = attribute_at(value.partner, "_example")
    known = -1 <= example < len(like.units.examples) and -1 <= value.partner.unit < like.units.count
    sized = all(attribute_at(reader, name).shape == attribute_at(like, name).shape for name in _OF_READERS)
    hands = all(-1 <= hand <= 1 for hand in value.partner.hands)
    return bool(same and known and sized and hands and reader.posterior.min() >= 0.0)
