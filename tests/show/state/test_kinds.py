"""Every class in a show's state is listed with its fields and their types, in the shows of all patches."""

import tempfile
from enum import Enum
from pathlib import Path

import pytest

from live.control.events import events
from live.control.events.elements import Points
from live.control.events.event_json import field_types
from live.rehearse.soak_test import SoakOptions, SoakTest
from live.show.loader import LoadedShow
from live.show.patch.patch_reader import parse_patch
from live.show.patch.patch_search_path import find_patch
from live.show.state.constants import attributes
from live.show.state.kind import NUMBERS, parse_type
from live.show.state.kinds import BY_CLASS, BY_NAME, CONSTANT_KINDS, METHODS
from live.show.state.snapshot import SnapshotError, Snapshotter, at_rest, index_limits, restore
from live.show.state.type_check import check_state
from tests.fixtures.mostly_long import mostly_long
from tests.show.desk.desk_show import DESK
from tests.show.made_show import GRAPH, PATCH
from tests.show.state.hostile import unpack_snapshot
from tests.show.state.test_snapshot import MADE, SCRIPT, capture_from, run

WORDS = {
    "int", "float", "bool", "str", "none", "bytes", "complex", "any", "array", "method", "event", "list", "row",
    "tuple", "set", "frozenset", "deque", "dict", "ordered", "counter", "|", *NUMBERS,
}  # fmt: skip


def type_words(found):
    yield found.word
    for each in found.items:
        yield from type_words(each)


def index_names(found):
    yield found.index_of
    for each in found.items:
        yield from index_names(each)


def test_every_type_word_is_known():
    many = index_limits(MADE.start())
    for kind in BY_NAME.values():
        for name, found in kind.types().items():
            unknown = set(type_words(found)) - WORDS - set(BY_NAME) - set(CONSTANT_KINDS)
            assert not unknown, f"{kind.name}.{name}: {unknown}"
            assert set(index_names(found)) <= {"", *many}, f"{kind.name}.{name}"


def test_every_kind_has_its_own_class_and_plain_name():
    assert len(BY_CLASS) == len(BY_NAME)
    for name, kind in BY_NAME.items():
        assert not name.startswith("live.")
        assert kind.cls.__module__ not in name
    assert {kind for kind, _ in METHODS} <= set(BY_NAME)


def test_all_slots_of_a_class_are_fields():
    for kind in BY_NAME.values():
        if issubclass(kind.cls, Enum) or kind.cls.__dictoffset__:
            continue
        slots = {name for cls in kind.cls.__mro__ for name in _slots(cls)} - {"__weakref__"}
        assert slots == {*kind.names, *kind.factories}, kind.name


def _slots(cls):
    slots = cls.__dict__.get("__slots__", ())
    return (slots,) if isinstance(slots, str) else slots


def test_types_are_parsed_and_formatted_unchanged():
    for text in ("int", "list[int|none]", "dict[str,tuple[float,float]]", "i4(node)", "row[str]|none", "tuple[]"):
        assert str(parse_type(text)) == text
    assert parse_type("f8*~").any_shape
    assert parse_type("f8*~").any_number
    for text in ("", "[int]", "int]", "list[int", "a b"):
        with pytest.raises((ValueError, IndexError)):
            parse_type(text)


class Unlisted:
    """A class that is not listed."""


def test_unlisted_class_or_field_is_refused_by_name():
    show = MADE.start()
    show.desk.master.cards["x"] = Unlisted()
    with pytest.raises(SnapshotError, match="Unlisted is of no kind"):
        Snapshotter(show).capture(0)
    show = MADE.start()
    show.desk.master.fresh = 1
    with pytest.raises(SnapshotError, match="the field fresh of Master is not listed in its kind 'master'"):
        Snapshotter(show).capture(0).seal()


def test_kind_with_changed_fields_is_refused_by_name(monkeypatch):
    show = MADE.start()
    run(show, 1, 20)
    _, data = capture_from(show, 20)
    kind = BY_NAME["master"]
    monkeypatch.setitem(BY_NAME, "master", type(kind)(kind.name, kind.cls, f"{kind.schema} fresh:int"))
    with pytest.raises(SnapshotError, match="'master' is of another version there, with other fields: fresh"):
        restore(MADE, data)


def test_snapshot_stays_readable_when_classes_move(monkeypatch):
    """A snapshot contains no names of modules or classes."""
    show = MADE.start()
    run(show, 1, 60)
    at, data = capture_from(show, 60)
    payload, _ = unpack_snapshot(data)
    assert b"live." not in payload
    assert b"GroupMotion" not in payload
    for kind in BY_NAME.values():
        if not issubclass(kind.cls, Enum):
            monkeypatch.setattr(kind.cls, "__module__", "somewhere.else")
    assert run(restore(MADE, data), at + 1, at + 40) == run(show, at + 1, at + 40)


def test_captured_snapshot_does_not_change_with_the_show():
    """A snapshot captured within a frame is sealed later, by another thread."""
    show, watched = MADE.start(), MADE.start()
    for each in (show, watched):
        run(each, 1, 300)
    source = Snapshotter(watched)
    taken = source.capture(300)
    then = Snapshotter(show).capture(300).seal()
    run(watched, 301, 420)
    assert source.capture(420) is not None
    assert restore(MADE, taken.seal()).state_hash() == restore(MADE, then).state_hash() == show.state_hash()


def test_shared_arrays_and_views_are_restored():
    show = MADE.start()
    run(show, 1, 100)
    restored = restore(MADE, capture_from(show, 100)[1])
    state = restored.motion.state
    assert state.position.base is state.velocity.base is state.flat
    assert restored.motion.casting is restored.casting
    assert restored.dancers is restored.scheduler.root_correction._dancers
    assert restored.graph is not None


@mostly_long("tick", [1, 60, 150, 300, 460, 640], quick=[0, 2])
def test_show_state_matches_its_listed_types(tick):
    for loaded in (MADE, LoadedShow(Path("desk.toml"), parse_patch(PATCH + DESK, "desk.toml"), GRAPH)):
        show = loaded.start()
        run(show, 1, tick, SCRIPT)
        check_state(show, "show", loaded.start(), index_limits(show))
        assert Snapshotter(show).capture(tick) is not None or not at_rest(show)


@pytest.mark.long
@pytest.mark.parametrize(
    "name",
    ["first_show", "samba", "tap", "contemporary", "ballet", "formations", "pairs", "cues", "score", "partner"],
)
def test_shows_of_all_patches_match_listed_types(name):
    """A minute with twelve players that use everything while the patch is edited: checked once a second."""
    path = find_patch(None if name == "first_show" else name)
    with tempfile.TemporaryDirectory() as folder:
        soak = SoakTest(SoakOptions(path, seed=13, hours=60.0 / 3600.0, players=12, calls=20, faults=3), Path(folder))
        looked = _record_checks(soak)
        soak.run()
    assert soak.report.problems == []
    assert len(looked) > 20


def _record_checks(soak):
    source, looked, frame = Snapshotter(soak.show), [], soak._frame

    def watched():
        frame()
        show, now = soak.show, soak.clock.now()
        if looked and now < looked[-1] + 1.0:
            return
        taken = source.capture(soak.engine.ticks.index)
        if taken is None:
            return
        looked.append(now)
        listens, show.follower.on_hint = show.follower.on_hint, None
        try:
            check_state(show, "show", show.hot_swap.make_show(show.patch, show.graph), index_limits(show))
        finally:
            show.follower.on_hint = listens

    soak._frame = watched
    return looked


def test_events_are_kinds_by_their_journal_names():
    for name, cls in events.EVENT_TYPES.items():
        assert BY_NAME[f"event-{name}"].cls is cls
        assert set(BY_NAME[f"event-{name}"].names) == set(attributes(cls(**_values(cls)))) - {"__weakref__"}


def _values(cls):
    from dataclasses import MISSING, fields

    usual = {float: 0.0, int: 0, str: "", bool: False, tuple[float, ...]: (), Points: ()}
    kinds = field_types(cls.__name__)
    return {each.name: usual[kinds[each.name]] for each in fields(cls) if each.default is MISSING}
