"""PosiStageNet packets built from the protocol's specification, independent of the project's decoder."""

import struct

DATA, INFO = 0x6755, 0x6756


def chunk(identity, data, *, nested=False):
    """A chunk: header and data."""
    return struct.pack("<HH", identity, len(data) | (0x8000 if nested else 0)) + data


def header(time=1_000_000, frame=1, packets=1, version=2):
    """The header chunk of a packet: time [µs], version, frame, number of packets in the frame."""
    return chunk(0, struct.pack("<QBBBB", time, version, 3, frame, packets))


def tracker(number, place, *, validity=None, more=b""):
    """A tracker of a data packet."""
    fields = chunk(0, struct.pack("<3f", *place)) + chunk(1, struct.pack("<3f", 0.0, 0.0, 0.0))
    if validity is not None:
        fields += chunk(3, struct.pack("<f", validity))
    return chunk(number, fields + more, nested=True)


def data_packet(*trackers, **facts):
    """A data packet with the positions of trackers."""
    return chunk(DATA, header(**facts) + chunk(1, b"".join(trackers), nested=True), nested=True)


def info_packet(names, system="hall", **facts):
    """An info packet with the names of trackers by number."""
    named = b"".join(chunk(number, chunk(0, name.encode()), nested=True) for number, name in names.items())
    return chunk(INFO, header(**facts) + chunk(1, system.encode()) + chunk(2, named, nested=True), nested=True)
