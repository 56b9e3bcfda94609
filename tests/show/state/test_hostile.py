"""Hostile snapshots are refused with a reason or restore a show; no code runs, and no process dies."""

import os
import pickle
import warnings
import zlib

import psutil
import pytest

from live.clock.ticks import TICK
from live.show.journal.journal_writer import read_snapshots
from live.show.state.byte_format import HEAD, MAX_TREE_BYTES
from live.show.state.snapshot import SnapshotError, restore, snapshot_header
from tests.show.state.hostile import Mutations, join_payload, pack_snapshot, split_payload, try_restore, unpack_snapshot
from tests.show.state.test_snapshot import MADE, capture_from, run

MANY = int(os.environ.get("HOSTILE_SNAPSHOTS", "300"))
"""The number of mutations; HOSTILE_SNAPSHOTS=100000 takes an hour."""
MORE_MB = 200.0

ran = []
"""Calls made by snapshot bytes."""


class PickledCall:
    """An object whose pickle would call a function (REDUCE)."""

    def __reduce__(self):
        return ran.append, ("called",)


@pytest.fixture(scope="module")
def tick_and_snapshot():
    show = MADE.start()
    run(show, 1, 410)
    return capture_from(show, 410)


@pytest.fixture(scope="module")
def fresh(tick_and_snapshot):
    return MADE.start(seed=snapshot_header(tick_and_snapshot[1])["seed"])


def rows_of(tree, kind):
    """The rows of objects of a kind."""
    return [row for row in tree[1].values() if row[0] >= 0 and tree[0][row[0]][0] == kind]


def refusal_text(data, fresh):
    with pytest.raises(SnapshotError) as error:
        restore(MADE, data, fresh=fresh)
    return str(error.value)


def test_pickle_in_snapshot_calls_no_code(tick_and_snapshot, fresh):
    _, facts = unpack_snapshot(tick_and_snapshot[1])
    for payload in (pickle.dumps(PickledCall()), HEAD.pack(9) + pickle.dumps(PickledCall())):
        assert "cannot be read" in refusal_text(pack_snapshot(payload, facts), fresh)
        assert "format 1" in refusal_text(pack_snapshot(payload, facts, snapshot=1), fresh)
    assert ran == []


@pytest.mark.parametrize(
    "path",
    [
        "__class__.__init__.__globals__",
        '__class__.__init__.__globals__["__builtins__"]["exec"]',
        "graph.__class__",
        "graph.library.node_count",
        "follower",
        "os.system",
        "live.show.loader.load_show",
    ],
)
def test_attribute_path_as_constant_is_refused(tick_and_snapshot, fresh, path):
    """An earlier reader ran foreign code: the bytes named an attribute path, and the object found there was called."""
    tree, content = split_payload(unpack_snapshot(tick_and_snapshot[1])[0])
    row = next(row for row in rows_of(tree, "hot-swap"))
    row[2 + tree[0][row[0]][2].index("graph")] = [path]
    words = refusal_text(pack_snapshot(join_payload(tree, content), unpack_snapshot(tick_and_snapshot[1])[1]), fresh)
    assert "names no known object" in words


@pytest.mark.parametrize(
    ("said", "words"),
    [
        (["os", ["name"], []], "there is no kind 'os'"),
        (["live.show.show.Show", [], ["graph"]], "there is no kind"),
        (["formation-spec", ["__class__"], []], "of another version"),
        (["timeline", ["tempo"], []], "beat_origin"),
        (["arrive", [], []], "there is no kind"),
        ([["show"], [], []], "there is no kind"),
        (["timeline", "tempo", 1], "there is no kind"),
        ("show", "table of kinds is invalid"),
    ],
)
def test_unlisted_kind_or_field_is_refused(tick_and_snapshot, fresh, said, words):
    tree, content = split_payload(unpack_snapshot(tick_and_snapshot[1])[0])
    tree[0][max(tree[0]) + 1] = said
    assert words in refusal_text(
        pack_snapshot(join_payload(tree, content), unpack_snapshot(tick_and_snapshot[1])[1]), fresh
    )


@pytest.mark.parametrize("name", ["__init__", "tick", "apply", "__class__", "_cut", "__getattribute__"])
def test_unlisted_method_is_refused(tick_and_snapshot, fresh, name):
    tree, content = split_payload(unpack_snapshot(tick_and_snapshot[1])[0])
    show = next(n for n, row in tree[1].items() if row[0] >= 0 and tree[0][row[0]][0] == "show")
    row, place = next(
        (row, place)
        for row in tree[1].values()
        for place, each in enumerate(row)
        if row[0] >= 0 and place > 1 and isinstance(each, list) and each[:1] == [False]
    )
    row[place] = [False, [show], name]
    assert "has no method" in refusal_text(
        pack_snapshot(join_payload(tree, content), unpack_snapshot(tick_and_snapshot[1])[1]), fresh
    )


def test_wrong_type_index_or_shape_is_refused_with_field_name(tick_and_snapshot, fresh):
    payload, facts = unpack_snapshot(tick_and_snapshot[1])

    def with_field(kind, field, value):
        tree, content = split_payload(payload)
        row = next(row for row in rows_of(tree, kind))
        _, plain, others = tree[0][row[0]]
        if field in plain:
            row[1][plain.index(field)] = value
        else:
            row[2 + others.index(field)] = value
        return pack_snapshot(join_payload(tree, content), facts)

    assert "timeline.tempo is str" in refusal_text(with_field("timeline", "tempo", "120"), fresh)
    assert "show.seed is float" in refusal_text(with_field("show", "seed", 0.5), fresh)
    tree, content = split_payload(payload)
    number = next(n for n, row in tree[1].items() if row[0] == -7 and row[1] == "<i4" and row[2] == [len(fresh.group)])
    tree, content = split_payload(payload)
    tree[1][number][2] = [1, len(fresh.group)]
    assert "has the shape" in refusal_text(pack_snapshot(join_payload(tree, content), facts), fresh)
    row = next(row for row in rows_of(tree, "danced"))
    name = row[2 + tree[0][row[0]][2].index("node")][0]
    tree, content = split_payload(payload)
    arrays = [number for number, row in tree[1].items() if row[0] in (-7, -8)]
    place = sum(tree[2][: arrays.index(name)])
    content = content[:place] + b"\xff\xff\xff\x7f" + content[place + 4 :]
    words = refusal_text(pack_snapshot(join_payload(tree, content), facts), fresh)
    assert "danced.node holds node indices" in words


def test_declared_large_sizes_allocate_no_memory(tick_and_snapshot, fresh):
    payload, facts = unpack_snapshot(tick_and_snapshot[1])
    before = psutil.Process().memory_info().rss
    tree, content = split_payload(payload)
    number = next(n for n, row in tree[1].items() if row[0] == -7)
    tree[1][number][2] = [1 << 39]
    large = [{}, {n: [-7, "<f8", [1 << 21]] for n in range(100)}, [0] * 100, [0]]
    bombs = [
        pack_snapshot(join_payload(large, b""), facts),
        pack_snapshot(join_payload(tree, content), facts),
        pack_snapshot(payload, facts, size=1 << 62),
        pack_snapshot(payload, facts, size=-1),
        pack_snapshot(HEAD.pack(MAX_TREE_BYTES) + b"\xdd\xff\xff\xff\xff" + bytes(64), facts),
        pack_snapshot(HEAD.pack(MAX_TREE_BYTES + 8) + b"\x90" * (MAX_TREE_BYTES + 8), facts),
        pack_snapshot(HEAD.pack(400) + b"\x91" * 400, facts),
        pack_snapshot(HEAD.pack(1 << 20) + b"\xdc\xff\xff" + b"\x90" * (1 << 20), facts),
        pack_snapshot(join_payload([{}, {n: [-1] for n in range(300_000)}, [], [0]], b""), facts),
        pack_snapshot(zlib.compress(bytes(1 << 25)), facts, size=1 << 25),
    ]
    for bomb in bombs:
        assert refusal_text(bomb, fresh)
    assert (psutil.Process().memory_info().rss - before) / 1e6 < MORE_MB


def test_cyclic_keys_and_deep_values_are_refused(tick_and_snapshot, fresh):
    payload, facts = unpack_snapshot(tick_and_snapshot[1])
    tree, content = split_payload(payload)
    spec = next(n for n, row in tree[1].items() if row[0] >= 0 and tree[0][row[0]][0] == "aims")
    for place in range(2, len(tree[1][spec])):
        tree[1][spec][place] = [None, [spec]]
    tree[1][-9999] = [-2, [None, [spec], [-9999]], 1]
    assert refusal_text(pack_snapshot(join_payload(tree, content), facts), fresh)
    deep = [0]
    for _ in range(400):
        deep = [None, deep]
    tree, content = split_payload(payload)
    tree[1][-9999] = [-1, deep]
    assert refusal_text(pack_snapshot(join_payload(tree, content), facts), fresh)


@pytest.mark.long
def test_mutated_snapshots_are_refused_or_restored(tick_and_snapshot, fresh):
    """The seed advances with the number of mutations, so a longer run begins with these."""
    at, data = tick_and_snapshot
    mutations, restored = Mutations(data, 21), 0
    before = psutil.Process().memory_info().rss
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of arithmetic with numbers that no show holds
        for _ in range(MANY):
            show, words = try_restore(MADE, mutations.next(), fresh)
            if show is None:
                assert words
                continue
            restored += 1
            fresh = MADE.start(seed=mutations.facts["seed"])
            _run_ticks(show, at)
    assert restored
    assert (psutil.Process().memory_info().rss - before) / 1e6 < MORE_MB
    assert ran == []


def _run_ticks(show, at):
    """Runs a restored show: a senseless state may raise a Python exception, but no kernel reads out of bounds."""
    try:
        view = show.view()
        for tick in range(at + 1, at + 5):
            show.tick(tick * TICK)
        show.fill(view, (at + 4) * TICK)
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError):
        pass


def test_snapshot_file_is_read_past_hostile_entries(tmp_path, tick_and_snapshot):
    """The intact snapshots are all read."""
    path = tmp_path / "night.jsonl.snap"
    _, facts = unpack_snapshot(tick_and_snapshot[1])
    path.write_bytes(
        tick_and_snapshot[1]
        + pack_snapshot(pickle.dumps(PickledCall()), facts, snapshot=1)
        + tick_and_snapshot[1][:-7]
        + tick_and_snapshot[1]
    )
    problems = []
    assert len(list(read_snapshots(path, problems))) == 2
    assert len(problems) == 2
    assert "format 1" in problems[0]
    assert ran == []
