import contextlib
import struct
import sys

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from pythonosc import osc_bundle_builder, osc_message, osc_packet
from pythonosc.osc_bundle_builder import OscBundleBuilder
from pythonosc.osc_message_builder import OscMessageBuilder

from live.control.osc.osc_codec import (
    IMMEDIATELY,
    MAX_ADDRESS_BYTES,
    MAX_ARGUMENTS,
    MAX_BLOB_BYTES,
    MAX_MESSAGES,
    MAX_PACKET_BYTES,
    MAX_STRING_BYTES,
    Message,
    OscRejected,
    decode,
)
from live.control.registry.rejections import Reason


def message(address, *arguments):
    """A message built by python-osc; arguments are values, or (type tag, value)."""
    builder = OscMessageBuilder(address)
    for tag, value in arguments:
        builder.add_arg(value, tag)
    return builder.build()


def bundle(*contents, time=osc_bundle_builder.IMMEDIATELY):
    builder = OscBundleBuilder(time)
    for content in contents:
        builder.add_content(content)
    return builder.build()


def element(data):
    return struct.pack(">i", len(data)) + data


def raw_bundle(*elements, timetag=1):
    return b"#bundle\0" + struct.pack(">Q", timetag) + b"".join(elements)


def reason(packet):
    with pytest.raises(OscRejected) as caught:
        decode(packet)
    return caught.value.reason


TAP = message("/dance/clock/tap").dgram

text = st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"]), max_size=60)
arguments = st.lists(
    st.one_of(
        st.tuples(st.just("i"), st.integers(-(2**31), 2**31 - 1)),
        st.tuples(st.just("h"), st.integers(-(2**63), 2**63 - 1)),
        st.tuples(st.just("f"), st.floats(allow_nan=False, allow_infinity=False, width=32)),
        st.tuples(st.just("d"), st.floats(allow_nan=False, allow_infinity=False)),
        st.tuples(st.just("s"), text),
        st.tuples(st.just("b"), st.binary(min_size=1, max_size=90)),
        st.tuples(st.just("m"), st.tuples(*[st.integers(0, 255)] * 4)),
        st.sampled_from([("T", True), ("F", False), ("N", None)]),
    ),
    max_size=20,
)
addresses = st.lists(st.text("abcXYZ019_-.~", min_size=1, max_size=12), min_size=1, max_size=5).map(
    lambda parts: "/" + "/".join(parts)
)


@given(addresses, arguments)
def test_every_type_decodes_as_in_python_osc(address, values):
    built = message(address, *values)
    (mine,) = decode(built.dgram)
    theirs = osc_message.OscMessage(built.dgram)
    assert mine == Message(theirs.address, tuple(theirs.params), IMMEDIATELY)
    assert [type(value) for value in mine.arguments] == [type(value) for value in theirs.params]


@pytest.mark.long
@given(
    st.recursive(st.tuples(addresses, arguments.map(lambda a: a[:3])), lambda c: st.lists(c, max_size=3), max_leaves=8)
)
@settings(max_examples=60)
def test_bundles_decode_as_in_python_osc(tree):
    def depth(node):
        return 0 if isinstance(node, tuple) else 1 + max(map(depth, node), default=0)

    def build(node):
        return message(node[0], *node[1]) if isinstance(node, tuple) else bundle(*map(build, node))

    packet = build([tree] if isinstance(tree, tuple) else tree).dgram
    if depth(tree) > 4:
        assert reason(packet) == Reason.DEPTH
        return
    theirs = [(m.message.address, tuple(m.message.params)) for m in osc_packet.OscPacket(packet).messages]
    assert [(m.address, m.arguments) for m in decode(packet)] == theirs


def test_time_tags_are_returned_and_impulse_is_none():
    assert [m.timetag for m in decode(raw_bundle(element(TAP), timetag=77 << 32))] == [77 << 32]
    inner = raw_bundle(element(TAP), timetag=9)
    assert [m.timetag for m in decode(raw_bundle(element(inner), element(TAP), timetag=5))] == [9, 5]
    assert decode(b"/a\0\0,ItN\0\0\0\0" + struct.pack(">Q", 2**40)) == [Message("/a", (None, 2**40, None), 1)]
    assert decode(raw_bundle()) == []


def test_memoryview_and_bytearray_decode_like_bytes():
    assert decode(memoryview(bytearray(TAP))) == decode(bytearray(TAP)) == decode(TAP)


NAN, INF = struct.pack(">f", float("nan")), struct.pack(">f", float("inf"))


@pytest.mark.parametrize(
    ("packet", "expected"),
    [
        (b"", Reason.PACKET_SIZE),
        (b"/a\0\0,\0\0\0" * 3000, Reason.PACKET_SIZE),
        (b"/a\0\0,\0\0", Reason.ALIGNMENT),
        (b"GET / HTTP/1.1\r\n\r\n\0\0", Reason.ADDRESS),
        (b"dance\0\0\0,\0\0\0", Reason.ADDRESS),
        (b"\0\0\0\0,\0\0\0", Reason.ADDRESS),
        (b"/a b\0\0\0\0,\0\0\0", Reason.ADDRESS),
        (b"/a\xff\0,\0\0\0", Reason.ADDRESS),
        (b"/a,b\0\0\0\0,\0\0\0", Reason.ADDRESS),
        (b"/a{#}\0\0\0,\0\0\0", Reason.ADDRESS),
        (b"#bundlf\0" + b"\0" * 8, Reason.ADDRESS),
        (b"#bundle\0", Reason.TRUNCATED),
        (b"#bundle\0\0\0\0\0", Reason.TRUNCATED),
        (b"/abc", Reason.UNTERMINATED),
        (b"/a\0x,\0\0\0", Reason.PADDING),
        (b"/a\0\0,\0x\0", Reason.PADDING),
        (b"/" + b"a" * MAX_ADDRESS_BYTES + b"\0\0\0,\0\0\0", Reason.UNTERMINATED),
        (b"/a\0\0", Reason.NO_TYPES),
        (b"/a\0\0\0\0\0\0", Reason.NO_TYPES),
        (b"/a\0\0" + struct.pack(">f", 1.0), Reason.NO_TYPES),
        (b"/a\0\0,f\0\0", Reason.TRUNCATED),
        (b"/a\0\0,d\0\0\0\0\0\0", Reason.TRUNCATED),
        (b"/a\0\0,m\0\0", Reason.TRUNCATED),
        (b"/a\0\0,b\0\0", Reason.TRUNCATED),
        (b"/a\0\0,s\0\0", Reason.UNTERMINATED),
        (b"/a\0\0,s\0\0abcd", Reason.UNTERMINATED),
        (b"/a\0\0,s\0\0ab\0c", Reason.PADDING),
        (b"/a\0\0,s\0\0\xc3(\0\0", Reason.TEXT),
        (b"/a\0\0,s\0\0\xed\xa0\x80\0", Reason.TEXT),
        (b"/a\0\0,s\0\0" + b"x" * (MAX_STRING_BYTES + 1) + b"\0\0\0", Reason.UNTERMINATED),
        (b"/a\0\0,\0\0\0\0\0\0\0", Reason.TRAILING),
        (b"/a\0\0,f\0\0" + bytes(8), Reason.TRAILING),
        (b"/a\0\0,f\0\0" + NAN, Reason.NOT_FINITE),
        (b"/a\0\0,f\0\0" + INF, Reason.NOT_FINITE),
        (b"/a\0\0,d\0\0" + struct.pack(">d", float("-inf")), Reason.NOT_FINITE),
        (b"/a\0\0,x\0\0" + bytes(4), Reason.UNKNOWN_TYPE),
        (b"/a\0\0,[f]\0\0\0\0" + bytes(4), Reason.UNKNOWN_TYPE),
        (b"/a\0\0,S\0\0a\0\0\0", Reason.UNKNOWN_TYPE),
        (b"/a\0\0,b\0\0" + struct.pack(">i", -4), Reason.BLOB),
        (b"/a\0\0,b\0\0" + struct.pack(">i", MAX_BLOB_BYTES + 1) + bytes(MAX_BLOB_BYTES + 4), Reason.BLOB),
        (b"/a\0\0,b\0\0" + struct.pack(">i", 2**31 - 1) + bytes(8), Reason.BLOB),
        (b"/a\0\0,b\0\0" + struct.pack(">i", 5) + bytes(4), Reason.TRUNCATED),
        (b"/a\0\0,b\0\0" + struct.pack(">i", 3) + b"abcd", Reason.PADDING),
        (b"/a\0\0," + b"T" * 60_000, Reason.PACKET_SIZE),
        (b"/a\0\0," + b"T" * 6_002 + b"\0", Reason.MANY_ARGUMENTS),
        (b"/a\0\0," + b"T" * (MAX_ARGUMENTS + 1) + b"\0\0", Reason.MANY_ARGUMENTS),
        (raw_bundle(struct.pack(">i", -4)), Reason.ELEMENT_SIZE),
        (raw_bundle(struct.pack(">i", -4), TAP), Reason.ELEMENT_SIZE),
        (raw_bundle(struct.pack(">i", -100), TAP), Reason.ELEMENT_SIZE),
        (raw_bundle(struct.pack(">i", 0) * 2000), Reason.ELEMENT_SIZE),
        (raw_bundle(struct.pack(">i", 2**31 - 1), TAP), Reason.ELEMENT_SIZE),
        (raw_bundle(struct.pack(">i", len(TAP) + 4), TAP), Reason.ELEMENT_SIZE),
        (raw_bundle(struct.pack(">i", 6), TAP), Reason.ELEMENT_SIZE),
        (raw_bundle(struct.pack(">i", len(TAP) - 4), TAP), Reason.NO_TYPES),
        (raw_bundle(element(TAP), element(b"/a\0\0,f\0\0")), Reason.TRUNCATED),
        (raw_bundle(*[element(TAP)] * (MAX_MESSAGES + 1)), Reason.MANY_MESSAGES),
    ],
)
def test_bad_packets_are_refused_with_their_reason(packet, expected):
    assert reason(packet) == expected


@pytest.mark.parametrize(
    ("cut_off", "expected"),
    [
        (b"/a\0\0,f\0\0", Reason.TRUNCATED),
        (b"/a\0\0,m\0\0", Reason.TRUNCATED),
        (b"/a\0\0,b\0\0", Reason.TRUNCATED),
        (b"/a\0\0,b\0\0" + struct.pack(">i", 8) + b"abcd", Reason.TRUNCATED),
        (b"/a\0\0,s\0\0abcd", Reason.UNTERMINATED),
    ],
)
def test_truncated_value_does_not_read_next_element(cut_off, expected):
    assert reason(raw_bundle(element(cut_off), element(TAP))) == expected


def test_values_at_the_limits_are_accepted():
    assert len(decode(b"/a\0\0," + b"T" * MAX_ARGUMENTS + b"\0\0\0")[0].arguments) == MAX_ARGUMENTS
    assert len(decode(raw_bundle(*[element(TAP)] * MAX_MESSAGES))) == MAX_MESSAGES
    assert len(decode(message("/a", ("s", "x" * MAX_STRING_BYTES)).dgram)[0].arguments[0]) == MAX_STRING_BYTES
    assert len(decode(message("/a", ("b", b"x" * MAX_BLOB_BYTES)).dgram)[0].arguments[0]) == MAX_BLOB_BYTES
    deepest = raw_bundle(element(raw_bundle(element(raw_bundle(element(raw_bundle(element(TAP))))))))
    assert [m.address for m in decode(deepest)] == ["/dance/clock/tap"]
    assert reason(raw_bundle(element(deepest))) == Reason.DEPTH


def test_deeply_nested_bundle_is_refused_without_recursion():
    packet = raw_bundle()
    while len(packet) + 20 <= MAX_PACKET_BYTES:
        packet = raw_bundle(element(packet))
    assert reason(packet) == Reason.DEPTH


GOOD = [
    TAP,
    message("/dance/attract", ("f", 1.5), ("f", -2.0), ("i", 3)).dgram,
    message("/dance/step", ("s", "samba"), ("d", 4.0)).dgram,
    message("/x", ("b", b"12345"), ("m", (1, 2, 3, 4)), ("h", 5), ("T", True)).dgram,
    bundle(message("/a", ("f", 1.0)), bundle(message("/b", ("s", "c")))).dgram,
]


@given(st.binary(max_size=400))
@example(b"#bundle\0" + bytes(8) + b"\xff\xff\xff\xfc")
def test_random_bytes_decode_or_are_refused(packet):
    try:
        messages = decode(packet)
    except OscRejected:
        return
    assert len(messages) <= MAX_MESSAGES
    assert sum(4 * len(m.arguments) for m in messages) <= 4 * len(packet)


@pytest.mark.long
@given(
    st.sampled_from(GOOD),
    st.lists(st.tuples(st.integers(0, 200), st.integers(0, 255)), max_size=4),
    st.integers(0, 60),
    st.binary(max_size=12),
)
@settings(max_examples=300)
def test_mutated_packets_decode_validly_or_are_refused(packet, changes, cut, tail):
    mutated = bytearray(packet)
    for place, byte in changes:
        mutated[place % len(mutated)] = byte
    mutated = mutated[: max(0, len(mutated) - cut)] + tail
    try:
        messages = decode(mutated)
    except OscRejected:
        return
    for one in messages:
        assert one.address.startswith("/")
        assert one.address.isascii()
        assert not set(one.address) & set(" #*,?[]{}")
        assert all(value == value for value in one.arguments)


WORST = [
    raw_bundle(*[element(b"/a\0\0," + b"T" * 62 + b"\0")] * 60)[:MAX_PACKET_BYTES],
    raw_bundle(*[element(raw_bundle(element(raw_bundle(element(raw_bundle()))))) for _ in range(100)]),
    raw_bundle(*[element(raw_bundle())] * 400),
    b"/" + b"a" * (MAX_PACKET_BYTES - 1),
    b"/a\0\0," + b"s" * 64 + b"\0\0\0" + b"x\0\0\0" * 2000,
    b"#bundle\0" * 1024,
]


@pytest.mark.parametrize("packet", WORST)
def test_decoding_calls_are_bounded_by_packet_length(packet):
    """Counted in calls instead of seconds: at most two per byte, built-in functions included."""
    assert len(packet) <= MAX_PACKET_BYTES
    calls = 0

    def count(frame, event, argument):
        nonlocal calls
        calls += event in ("call", "c_call")

    before = sys.getprofile()
    sys.setprofile(count)
    try:
        with contextlib.suppress(OscRejected):
            decode(packet)
    finally:
        sys.setprofile(before)
    assert 0 < calls <= 2 * len(packet)


@pytest.mark.parametrize("pattern", [b"/dance/*", b"/" + b"*" * 20 + b"x", b"/d[ab]", b"/d{a,b}", b"/a?"])
def test_patterns_are_decoded_unchanged(pattern):
    packet = pattern + b"\0" * (4 - len(pattern) % 4) + b",\0\0\0"
    assert decode(packet) == [Message(pattern.decode(), ())]
