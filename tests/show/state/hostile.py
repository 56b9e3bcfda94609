"""Hostile snapshots: damaged and crafted ones, each with a valid checksum."""

import hashlib
import json
import zlib

import msgpack
import numpy as np

from live.show.state.byte_format import HEAD
from live.show.state.snapshot import SnapshotError, restore

FOREIGN_VALUES = (
    None, True, False, 0, -1, 1, 7, 2**31 - 1, -(2**31), 2**63 - 1, 2**64 - 1, -(2**63), 1e308, -1e308, 0.5,
    float("nan"), float("inf"), "", "x", "graph", "patch", "__class__", "show", "complex", "frozenset", b"", bytes(9),
    [], [None], [0], [1], [-1], ["graph"], ["patch"], ["graph.library"], ["__class__.__init__.__globals__"],
    [True, "complex", 0.0, 0.0], [True, "frozenset", [0]], [True, "f8", 1.0], [False, [0], "tick"],
    [False, [0], "__init__"], [None, [None, [None]]], {}, {"a": 1}, msgpack.ExtType(1, b"\xff" * 40),
    msgpack.ExtType(7, b"x"), -10, -9, -8, -7, -6, -5, -4, -3, -2, "<f8", "|O8", "O", "<M8[s]", [1 << 40], [-1, 5],
)  # fmt: skip
PROBABILITIES = (0.1, 0.1, 0.2, 0.2, 0.1, 0.2, 0.1)
"""The probability of each kind of mutation."""
EXTREME = {
    "f": (1e9, -1e9, 1e9, -1e9, 1e-30, -1.0, 0.5, 7.0, 63.0, 1e4, -1e4, 3e7, np.nan, np.inf),
    "i": (-1, -1, 0, 0, 1, 2, 5, 10, 1000, 2**31 - 1),
    "u": (255, 128, 7),
    "b": (1, 0),
}


def pack_snapshot(payload, facts, **other):
    """A snapshot of these bytes with a valid checksum."""
    packed = zlib.compress(payload, 1)
    header = {**facts, "size": len(payload), **other}
    line = json.dumps(header, separators=(",", ":")).encode()
    check = hashlib.blake2b(line + packed, digest_size=16).hexdigest()
    return json.dumps(header | {"check": check}, separators=(",", ":")).encode() + b"\n" + packed


def unpack_snapshot(data):
    """Payload and header facts of a snapshot."""
    line, _, packed = data.partition(b"\n")
    facts = json.loads(line)
    facts.pop("check")
    return zlib.decompress(packed), facts


def split_payload(payload):
    """The tree of a payload, and the content of its arrays."""
    (size,) = HEAD.unpack_from(payload)
    tree = msgpack.unpackb(payload[HEAD.size : HEAD.size + size], strict_map_key=False)
    return tree, payload[HEAD.size + size :]


def join_payload(tree, content):
    """The payload of a tree and its array content."""
    data = msgpack.packb(tree)
    return HEAD.pack(len(data)) + data + content


class Mutations:
    """Endless seeded mutations of one snapshot."""

    def __init__(self, data, seed):
        self.payload, self.facts = unpack_snapshot(data)
        self.data, self.chance = data, np.random.default_rng(seed)
        self.numbers = tuple(split_payload(self.payload)[0][1])

    def next(self):
        """The next mutation."""
        kinds = (
            self.flip_file_bytes,
            self.flip_tree_bytes,
            self.replace_any,
            self.replace_same_type,
            self.replace_same_type,
            self.fill_arrays,
            self.truncate,
        )
        return kinds[int(self.chance.choice(len(kinds), p=PROBABILITIES))]()

    def flip_file_bytes(self):
        """Changes bytes of the whole file."""
        data = bytearray(self.data)
        for _ in range(int(self.chance.integers(1, 8))):
            data[int(self.chance.integers(len(data)))] = int(self.chance.integers(256))
        return bytes(data)

    def flip_tree_bytes(self):
        """Changes bytes of the tree."""
        (size,) = HEAD.unpack_from(self.payload)
        data = bytearray(self.payload)
        for _ in range(int(self.chance.integers(1, 6))):
            data[int(self.chance.integers(HEAD.size + size))] = int(self.chance.integers(256))
        return pack_snapshot(bytes(data), self.facts)

    def truncate(self):
        """Truncates the payload or declares a wrong size."""
        end = int(self.chance.integers(len(self.payload)))
        size = int(self.chance.choice([len(self.payload), 0, end, 1 << 24, 1 << 40]))
        return pack_snapshot(self.payload[:end], self.facts, size=size)

    def replace_any(self):
        """Replaces values of the tree by values of any type."""
        tree, content = split_payload(self.payload)
        rows = list(tree[1].values())
        for _ in range(int(self.chance.integers(1, 4))):
            row = self.values(rows)
            if row:
                row[int(self.chance.integers(len(row)))] = self.foreign_value(rows)
        return pack_snapshot(join_payload(tree, content), self.facts)

    def replace_same_type(self):
        """Replaces one value by another of its type, which no type check detects."""
        tree, content = split_payload(self.payload)
        rows = list(tree[1].values())
        while True:
            row = self.values(rows)
            place = int(self.chance.integers(len(row))) if row else 0
            if row and (found := self.same_type_value(row[place], rows)) is not None:
                row[place] = found
                return pack_snapshot(join_payload(tree, content), self.facts)

    def values(self, rows):
        """A row, or its plain values."""
        row = rows[int(self.chance.integers(len(rows)))]
        plain = type(row[0]) is int and row[0] >= 0 and isinstance(row[1], list)
        return row[1] if plain and self.chance.random() < 0.6 else row

    def same_type_value(self, value, rows):
        """Another value of the same type; None where there is none."""
        if type(value) is bool:
            return not value
        if type(value) is int:
            return int(self.chance.choice((0, 1, -1, 2, 7, 63, 64, 1000, 2**31 - 1, -(2**31), 2**62)))
        if type(value) is float:
            return float(self.chance.choice((0.0, -1.0, 1e-300, 1e300, -1e300, np.inf, -np.inf, np.nan, 1e9, 0.5)))
        if type(value) is str:
            return str(self.chance.choice(("", "x", "*", "a" * 4000, "now", "circle", "\x00")))
        if isinstance(value, list) and len(value) == 1 and type(value[0]) is int:
            return [int(self.chance.choice(list(self.numbers)))]
        return None

    def foreign_value(self, rows):
        """A value that does not belong here."""
        if self.chance.random() < 0.4:
            return [int(self.chance.choice(list(self.numbers)))]
        if self.chance.random() < 0.3:
            return [int(each) for each in self.chance.integers(-5, 400, int(self.chance.integers(4)))]
        return FOREIGN_VALUES[int(self.chance.integers(len(FOREIGN_VALUES)))]

    def fill_arrays(self):
        """Fills arrays with numbers that no show contains."""
        tree, content = split_payload(self.payload)
        data, place, sizes = bytearray(content), 0, iter(tree[2])
        for row in tree[1].values():
            if row[0] not in (-7, -8):
                continue
            kind, size = np.dtype(row[1]), next(sizes)
            numbers = np.frombuffer(data, kind, size // kind.itemsize, place)
            place += size
            if size and self.chance.random() < 0.02:
                places = self.chance.integers(len(numbers), size=1 + len(numbers) // 9)
                numbers[places] = self.chance.choice(EXTREME.get(kind.kind, (0,)))
        return pack_snapshot(join_payload(tree, bytes(data)), self.facts)


def try_restore(loaded, data, fresh):
    """The show restored from these bytes and an empty text, or None and the reason of the refusal."""
    try:
        return restore(loaded, data, fresh=fresh), ""
    except SnapshotError as error:
        return None, str(error)
