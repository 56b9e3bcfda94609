"""Tests of the frames of the stage for phones: what they say, how large they are, and how they come to phones."""

import asyncio
from types import SimpleNamespace

import aiohttp
import numpy as np
import pytest

from live.base.element_kinds import ATTRACTOR, CROSSING, FLOW, PARTICIPANT, PATH, REPULSOR, SPREADER, VORTEX, WANDER
from live.control.audience.broadcaster import MAX_UNSENT_FRAMES, Broadcaster
from live.control.audience.stage_lights import (
    AROUND,
    CROSS,
    GATHER,
    GO,
    LEAVE,
    MARGIN,
    MAX_ELEMENTS,
    MAX_PLACES,
    MAX_POINTS,
    SPREAD,
    STAGE,
    STAGE_EVERY,
    ElementLight,
    StageLights,
    colour_texts,
    with_interval,
)
from live.control.audience.websocket_reader import binary_frame
from tests.control.audience.made_gateway import FakePhone, current_key, open_gateway, until

HALF = (6.0, 4.0)
STEP = tuple(2.0 * size * (1.0 + 2.0 * MARGIN) / 255 for size in HALF)
"""How far apart two places can be told [m]."""


def parse(frame):
    """The places (N, 3) as x, z [m] and group, and the elements as (shape, level, radius [m], points)."""
    verb, _, count, elements = frame[:4]
    assert verb == STAGE
    rows = np.frombuffer(frame[4 : 4 + 3 * count], np.uint8).reshape(count, 3).astype(float)
    rows[:, :2] = metres(rows[:, :2])
    rest, found = frame[4 + 3 * count :], []
    for _ in range(elements):
        shape, level, radius, points = rest[:4]
        corners = np.frombuffer(rest[4 : 4 + 2 * points], np.uint8).reshape(points, 2).astype(float)
        found.append((shape, level / 255, radius / 255 * 2.0 * HALF[0], metres(corners)))
        rest = rest[4 + 2 * points :]
    assert rest == b""
    return rows, found


def metres(shares):
    """Positions [m] of a frame's numbers: the inverse of the encoding, as the page has it."""
    return ((shares / 255 * (1.0 + 2.0 * MARGIN) - MARGIN) * 2.0 - 1.0) * HALF


def test_dancers_are_told_within_a_step_with_groups_and_keep_their_places():
    rng, lights = np.random.default_rng(2), StageLights()
    position = rng.uniform(-1.0, 1.0, (9, 2)).astype(np.float32) * HALF
    group = np.array([1, 1, 2, 0, 2, 3, 1, 0, 2], np.int32)
    rows, elements = parse(lights.frame(position, group, (), HALF))
    there = group > 0
    assert elements == []
    assert rows[:, 2].tolist() == group[there].tolist()
    assert (np.abs(rows[:, :2] - position[there]) <= np.array(STEP) / 2 + 1e-6).all()
    group[0], group[3] = 0, 5  # one leaves, and another enters where they stood in the frame
    rows, _ = parse(lights.frame(position, group, (), HALF))
    assert rows[:, 2].tolist() == [5, 1, 2, 2, 3, 1, 2]
    group[:] = 0
    assert len(parse(lights.frame(position, group, (), HALF))[0]) == 0


def test_crowd_is_thinned_out_evenly_and_frames_are_bounded():
    lights = StageLights()
    place = np.linspace(-5.0, 5.0, 1000)
    position = np.stack([place, np.zeros(1000)], axis=1).astype(np.float32)
    group = np.ones(1000, np.int32)
    long = ElementLight(PATH, 0, tuple((0.1 * k, 0.0) for k in range(-30, 31)), 0.5, 1.0)
    frame = lights.frame(position, group, (long,) * 40, HALF)
    rows, elements = parse(frame)
    assert len(rows) == MAX_PLACES
    assert np.diff(np.sort(rows[:, 0])).max() < 3.0 * 10.0 / MAX_PLACES
    assert len(elements) == MAX_ELEMENTS
    assert len(elements[0][3]) == MAX_POINTS
    assert elements[0][3][0][0] == pytest.approx(-3.0, abs=STEP[0])
    assert elements[0][3][-1][0] == pytest.approx(3.0, abs=STEP[0])
    assert len(frame) == 4 + 3 * MAX_PLACES + MAX_ELEMENTS * (4 + 2 * MAX_POINTS)
    group[::2] = 0  # who is still there keeps their place
    before, after = rows, parse(lights.frame(position, group, (), HALF))[0]
    same = (before[:, :2] == after[:, :2]).all(axis=1)
    assert 0.3 < same.mean() < 0.7
    assert len(after) == MAX_PLACES


def test_elements_have_shapes_and_those_without_a_place_are_left_out():
    kinds = (
        (ATTRACTOR, 0), (PARTICIPANT, 0), (REPULSOR, 0), (SPREADER, 0), (CROSSING, 0), (FLOW, 0), (FLOW, VORTEX),
        (PATH, 0), (WANDER, 0),
    )  # fmt: skip
    shown = [ElementLight(kind, flow, ((1.0, -1.0), (2.0, 1.0)), 1.5, 0.5) for kind, flow in kinds]
    _, elements = parse(
        StageLights().frame(np.zeros((0, 2), np.float32), np.zeros(0, np.int32), (*shown, shown[0]), HALF)
    )
    assert [row[0] for row in elements] == [GATHER, GATHER, LEAVE, SPREAD, CROSS, GO, AROUND, GO, GATHER]
    assert elements[0][1] == pytest.approx(0.5, abs=0.01)
    assert elements[0][2] == pytest.approx(1.5, abs=0.05)
    np.testing.assert_allclose(elements[0][3], [(1.0, -1.0), (2.0, 1.0)], atol=STEP[0])
    faded = ElementLight(ATTRACTOR, 0, ((0.0, 0.0),), 0.0, 0.0)
    assert StageLights().frame(np.zeros((0, 2), np.float32), np.zeros(0, np.int32), (faded,), HALF)[3] == 0
    far = ElementLight(ATTRACTOR, 0, ((1e9, -1e9),), 1e9, 9.0)  # what is outside stands at the border
    _, [(_, level, radius, points)] = parse(
        StageLights().frame(np.full((1, 2), 1e9, np.float32), np.ones(1, np.int32), (far,), HALF)
    )
    assert (level, radius) == (1.0, 12.0)
    np.testing.assert_allclose(points, [(7.5, -5.0)])


def test_group_colours_are_lights_of_the_same_hue():
    assert colour_texts(np.array([(1.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.02, 0.02, 0.02)])) == (
        "#ff1313", "#ffffff", "#ffffff",
    )  # fmt: skip


def test_all_phones_get_the_same_frame_and_slow_ones_none():
    frame = binary_frame(with_interval(bytes((STAGE, 0, 0, 0)), 0.2))
    assert frame == bytes((0x82, 4, STAGE, 20, 0, 0))
    assert binary_frame(b"x" * 300)[:4] == bytes((0x82, 126, 1, 44))
    written, waiting = [], [0, MAX_UNSENT_FRAMES + 1]

    def phone(row):
        transport = SimpleNamespace(
            is_closing=lambda: False, get_write_buffer_size=lambda: waiting[row], write=lambda data: written.append(row)
        )
        return SimpleNamespace(transport=transport)

    hall = SimpleNamespace(phones=SimpleNamespace(by_number={1: phone(0), 2: phone(1)}))
    broadcaster = Broadcaster(hall)
    for one in hall.phones.by_number.values():
        broadcaster._put(one, frame)
    assert (written, broadcaster.missed_frames) == ([0], 1)


def test_stage_of_show_reaches_phones_at_a_modest_rate():
    async def test():
        async with open_gateway() as (gateway, show, address), aiohttp.ClientSession() as session:
            phones = [await FakePhone(session, address).join(current_key(show)) for _ in range(2)]
            began, sent = show.now(), 0
            frames = {phone: [] for phone in phones}
            while min(map(len, frames.values())) < 4:
                sent += 1
                show.tell(("stage", bytes((STAGE, 0, 1, 0, sent % 256, 7, 1)), ("#ff0000",)))
                for phone in phones:
                    message = await phone.hear()
                    if message.type is aiohttp.WSMsgType.BINARY:
                        frames[phone].append(message.data)
            assert show.now() - began >= 2 * STAGE_EVERY
            assert frames[phones[0]][:3] == frames[phones[1]][:3]
            assert all(data[:2] == bytes((STAGE, 20)) for data in frames[phones[0]])
            await until(lambda: gateway.session.phones.by_number)
            late = await FakePhone(session, address).join(current_key(show))
            while late.said.get("g") != ["#ff0000"]:
                await late.hear()

    asyncio.run(asyncio.wait_for(test(), 60.0))
