"""Whatever somebody makes of a snapshot: it is refused in words, or it is a show; nothing runs, and nothing dies."""

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
from tests.show.state.hostile import Mutations, halves, joined, opened, sealed, tried
from tests.show.state.test_snapshot import MADE, run, taken_at

MANY = int(os.environ.get("HOSTILE_SNAPSHOTS", "300"))
"""How many are tried; HOSTILE_SNAPSHOTS=100000 takes an hour."""
MORE_MB = 200.0

ran = []
"""What bytes have called."""


class Calls:
    """Bytes that would call something: REDUCE of a pickle."""

    def __reduce__(self):
        return ran.append, ("called",)


@pytest.fixture(scope="module")
def taken():
    show = MADE.start()
    run(show, 1, 410)
    return taken_at(show, 410)


@pytest.fixture(scope="module")
def fresh(taken):
    return MADE.start(seed=snapshot_header(taken[1])["seed"])


def rows_of(tree, kind):
    """The rows of objects of a kind."""
    return [row for row in tree[1].values() if row[0] >= 0 and tree[0][row[0]][0] == kind]


def refused(data, fresh):
    with pytest.raises(SnapshotError) as error:
        restore(MADE, data, fresh=fresh)
    return str(error.value)


def test_a_pickle_calls_nothing(taken, fresh):
    _, facts = opened(taken[1])
    for payload in (pickle.dumps(Calls()), HEAD.pack(9) + pickle.dumps(Calls())):
        assert "cannot be read" in refused(sealed(payload, facts), fresh)
        assert "format 1" in refused(sealed(payload, facts, snapshot=1), fresh)
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
def test_a_constant_is_a_row_of_the_readers_own_table_and_no_path(taken, fresh, path):
    """What ran foreign code: a path of attributes that the bytes name, and the call of what lies there."""
    tree, content = halves(opened(taken[1])[0])
    row = next(row for row in rows_of(tree, "show"))
    row[2 + tree[0][row[0]][2].index("graph")] = [path]
    words = refused(sealed(joined(tree, content), opened(taken[1])[1]), fresh)
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
def test_a_kind_is_one_of_the_list_with_its_fields(taken, fresh, said, words):
    tree, content = halves(opened(taken[1])[0])
    tree[0][max(tree[0]) + 1] = said
    assert words in refused(sealed(joined(tree, content), opened(taken[1])[1]), fresh)


@pytest.mark.parametrize("name", ["__init__", "tick", "apply", "__class__", "_cut", "__getattribute__"])
def test_a_method_is_one_of_the_list(taken, fresh, name):
    tree, content = halves(opened(taken[1])[0])
    show = next(n for n, row in tree[1].items() if row[0] >= 0 and tree[0][row[0]][0] == "show")
    row, place = next(
        (row, place)
        for row in tree[1].values()
        for place, each in enumerate(row)
        if row[0] >= 0 and place > 1 and isinstance(each, list) and each[:1] == [False]
    )
    row[place] = [False, [show], name]
    assert "has no method" in refused(sealed(joined(tree, content), opened(taken[1])[1]), fresh)


def test_a_field_of_another_type_an_index_too_large_and_another_shape_are_named(taken, fresh):
    payload, facts = opened(taken[1])

    def with_field(kind, field, value):
        tree, content = halves(payload)
        row = next(row for row in rows_of(tree, kind))
        _, plain, others = tree[0][row[0]]
        if field in plain:
            row[1][plain.index(field)] = value
        else:
            row[2 + others.index(field)] = value
        return sealed(joined(tree, content), facts)

    assert "timeline.tempo is str" in refused(with_field("timeline", "tempo", "120"), fresh)
    assert "show.seed is float" in refused(with_field("show", "seed", 0.5), fresh)
    tree, content = halves(payload)
    number = next(n for n, row in tree[1].items() if row[0] == -7 and row[1] == "<i4" and row[2] == [len(fresh.group)])
    tree, content = halves(payload)
    tree[1][number][2] = [1, len(fresh.group)]
    assert "has the shape" in refused(sealed(joined(tree, content), facts), fresh)
    row = next(row for row in rows_of(tree, "danced"))
    name = row[2 + tree[0][row[0]][2].index("node")][0]
    tree, content = halves(payload)
    arrays = [number for number, row in tree[1].items() if row[0] in (-7, -8)]
    place = sum(tree[2][: arrays.index(name)])
    content = content[:place] + b"\xff\xff\xff\x7f" + content[place + 4 :]
    words = refused(sealed(joined(tree, content), facts), fresh)
    assert "danced.node holds node indices" in words


def test_what_says_that_it_is_large_asks_for_no_memory(taken, fresh):
    payload, facts = opened(taken[1])
    before = psutil.Process().memory_info().rss
    tree, content = halves(payload)
    number = next(n for n, row in tree[1].items() if row[0] == -7)
    tree[1][number][2] = [1 << 39]
    large = [{}, {n: [-7, "<f8", [1 << 21]] for n in range(100)}, [0] * 100, [0]]
    bombs = [
        sealed(joined(large, b""), facts),
        sealed(joined(tree, content), facts),
        sealed(payload, facts, size=1 << 62),
        sealed(payload, facts, size=-1),
        sealed(HEAD.pack(MAX_TREE_BYTES) + b"\xdd\xff\xff\xff\xff" + bytes(64), facts),
        sealed(HEAD.pack(MAX_TREE_BYTES + 8) + b"\x90" * (MAX_TREE_BYTES + 8), facts),
        sealed(HEAD.pack(400) + b"\x91" * 400, facts),
        sealed(HEAD.pack(1 << 20) + b"\xdc\xff\xff" + b"\x90" * (1 << 20), facts),
        sealed(joined([{}, {n: [-1] for n in range(300_000)}, [], [0]], b""), facts),
        sealed(zlib.compress(bytes(1 << 25)), facts, size=1 << 25),
    ]
    for bomb in bombs:
        assert refused(bomb, fresh)
    assert (psutil.Process().memory_info().rss - before) / 1e6 < MORE_MB


def test_a_circle_of_keys_and_a_deep_value_are_refused(taken, fresh):
    payload, facts = opened(taken[1])
    tree, content = halves(payload)
    spec = next(n for n, row in tree[1].items() if row[0] >= 0 and tree[0][row[0]][0] == "aims")
    for place in range(2, len(tree[1][spec])):
        tree[1][spec][place] = [None, [spec]]
    tree[1][-9999] = [-2, [None, [spec], [-9999]], 1]
    assert refused(sealed(joined(tree, content), facts), fresh)
    deep = [0]
    for _ in range(400):
        deep = [None, deep]
    tree, content = halves(payload)
    tree[1][-9999] = [-1, deep]
    assert refused(sealed(joined(tree, content), facts), fresh)


def test_mutations_are_refused_or_are_shows(taken, fresh):
    """The seed counts on with their number, so that a longer run begins with these."""
    at, data = taken
    mutations, restored = Mutations(data, 21), 0
    before = psutil.Process().memory_info().rss
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of arithmetic with numbers that no show holds
        for _ in range(MANY):
            show, words = tried(MADE, mutations.next(), fresh)
            if show is None:
                assert words
                continue
            restored += 1
            fresh = MADE.start(seed=mutations.facts["seed"])
            _danced_on(show, at)
    assert restored
    assert (psutil.Process().memory_info().rss - before) / 1e6 < MORE_MB
    assert ran == []


def _danced_on(show, at):
    """What was read is a show: it may fail as one whose state makes no sense, in Python; no kernel reads beyond."""
    try:
        view = show.view()
        for tick in range(at + 1, at + 5):
            show.tick(tick * TICK)
        show.fill(view, (at + 4) * TICK)
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError):
        pass


def test_a_file_of_snapshots_with_hostile_ones_is_read_on(tmp_path, taken):
    """Those that are whole are there all the same."""
    path = tmp_path / "night.jsonl.snap"
    _, facts = opened(taken[1])
    path.write_bytes(taken[1] + sealed(pickle.dumps(Calls()), facts, snapshot=1) + taken[1][:-7] + taken[1])
    problems = []
    assert len(list(read_snapshots(path, problems))) == 2
    assert len(problems) == 2
    assert "format 1" in problems[0]
    assert ran == []
