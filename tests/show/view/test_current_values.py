"""CurrentValues: values read from a show match those that were set, and reading changes no state."""

import pytest

from live.control.registry.control import Control
from live.control.registry.registry import READABLE, REGISTRY, Values
from live.control.registry.rejections import Rejection
from live.show.desk.parameter_table import ROWS
from live.show.view.status import Status
from live.show.view.telemetry import CurrentValues
from tests.show.desk.desk_show import DESK, DeskSession

ELSEWHERE = {"/dance/click", "/dance/latency/input", "/dance/latency/output", "/dance/latency/display",
             "/dance/latency/projector", "/dance/status/document", "/dance/status/document_answers",
             "/dance/status/document_log", "/dance/status/next"}  # fmt: skip
SLOW = {"/dance/stage", "/dance/clock/metre", "/dance/clock/source", "/dance/output/fade"}
REFUSED = {"/dance/motion/texture"}  # in a show without recordings
REFUSED |= {f"/dance/partner/{key}" for key in ("on", "amount", "stretch", "hands", "style")}  # in one without partners


def different_value(control: Control, now: tuple) -> tuple:
    """A value that differs from the current one of a control."""
    values = []
    for argument, value in zip(control.value_arguments, now, strict=False):
        if argument.type == "bool":
            values.append(not value)
        elif control.address in ROWS and ROWS[control.address].kind == "names":
            values.append(next(name for name in ROWS[control.address].choices if name != value))
        elif control.address == "/dance/answer/how":
            values.append("next" if value != "next" else "other")
        elif argument.type in ("name", "text"):
            values.append("back" if value != "back" else "front")
        else:
            low, high = argument.minimum, argument.maximum
            values.append(float(f"{low + (high - low) * (0.25 if value > low + (high - low) / 2 else 0.75):.4g}"))
    return tuple(values)


@pytest.fixture(scope="module")
def show():
    return DeskSession(DESK + '[[mocap]]\nname = "anna"\n[[answer]]\nname = "echo"\nperformer = "anna"\n').show


def current_values(show):
    return CurrentValues(show, Status(show, rejected=dict, memory=lambda: 1.0))


def test_every_readable_control_has_a_value(show):
    found = current_values(show).changes()
    assert set(found) == set(READABLE) - ELSEWHERE


@pytest.mark.long
def test_set_value_is_read_back_once(show):
    readable = current_values(show)
    values = Values()
    values.update(readable.changes())
    before = show.state_hash()
    assert readable.changes() == {}
    assert show.state_hash() == before
    for control in REGISTRY:
        if not control.value or control.address in ELSEWHERE | SLOW | REFUSED:
            continue
        address, now = next(values.messages(control.address))
        wanted = different_value(control, now[: control.value])
        event = REGISTRY.call(address, wanted, 0.0, "test")
        assert not isinstance(event, Rejection), event
        assert show.apply(event), control.address
        for _ in range(24):
            show.desk.tick(show.clock.now(show.state.position))
        changes = readable.changes()
        assert control.address in changes, control.address
        values.update(changes)
        (got,) = {row[: control.value] for _, row in values.messages(control.address)}
        for one, other in zip(got, wanted, strict=True):
            assert one == (other if isinstance(other, str) else pytest.approx(other, rel=1e-5)), control.address
        assert [type(value) for value in got] == [type(value) for value in wanted]


def test_differing_groups_are_reported_by_name(show):
    readable = current_values(show)
    readable.changes()
    first, *others = show.desk.parameters.table.group_names
    assert others
    show.apply(REGISTRY.call("/dance/motion/larger", (0.25, first), 0.0, "test"))
    values = Values()
    values.update(readable.changes())
    told = list(values.messages("/dance/motion/larger"))
    assert ("/dance/motion/larger", (0.25, first)) in told
    assert len(told) == 1 + len(others)
    show.apply(REGISTRY.call("/dance/motion/larger", (0.25,), 0.0, "test"))
    assert readable.changes()["/dance/motion/larger"] == (("", (0.25,)),)


def test_differing_performers_are_reported_at_own_addresses():
    show = DeskSession(
        DESK + '[[mocap]]\nname = "anna"\n[[mocap]]\nname = "ben b"\nmirrored = true\ncanon = "back"\n'
    ).show
    readable, values = current_values(show), Values()
    values.update(readable.changes())
    mirrored = list(values.messages("/dance/mocap/mirrored"))
    assert mirrored == [("/dance/mocap/anna/mirrored", (False,)), ("/dance/mocap/mirrored", ("ben b", True))]
    assert list(values.messages("/dance/mocap/anna/place")) == [("/dance/mocap/anna/place", (0.0, 0.0, 0.0, 1.0))]
    assert values.rows("/dance/mocap/canon") == (("anna", ("none", 2.0)), ("ben b", ("back", 2.0)))
    assert "/dance/mocap/nobody/place" not in values
    show.apply(REGISTRY.call("/dance/mocap/anna/place", (1.0, -2.0, 33.0), 0.0, "test"))
    changes = readable.changes()
    assert changes == {"/dance/mocap/place": (("anna", (1.0, -2.0, 33.0, 1.0)), ("ben b", (0.0, 0.0, 0.0, 1.0)))}
