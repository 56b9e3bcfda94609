"""Network cards of addresses: the kernel's neighbor table in a network of two machines, and malformed dumps."""

import asyncio
import os
import random
import shutil
import socket
import struct
import subprocess
import sys
import textwrap

import pytest

from live.control.audience.arp_table import ArpTable, parse_neighbours
from live.control.audience.client_address import parse_address

CARD = b"\x02\x00\x00\x00\x00\x07"


def entry(address, card=CARD, state=0x02):
    family = socket.AF_INET6 if ":" in address else socket.AF_INET
    body = struct.pack("=BxHiHBB", family, 0, 2, state, 0, 1)
    for kind, value in ((1, socket.inet_pton(family, address)), (2, card)):
        body += struct.pack("=HH", 4 + len(value), kind) + value + b"\0" * (-len(value) % 4)
    return struct.pack("=IHHII", 16 + len(body), 28, 2, 1, 0) + body


DONE = struct.pack("=IHHIIi", 20, 3, 2, 1, 0, 0)


def test_neighbor_dump_is_read_to_end_without_cardless_entries():
    data = entry("192.0.2.1") + entry("fe80::7", b"\x02\0\0\0\0\x08") + entry("192.0.2.2", state=0x20)
    data += entry("127.0.0.1", b"\0" * 6) + DONE + entry("192.0.2.9")
    found = list(parse_neighbours(data))
    assert found == [(parse_address("192.0.2.1"), CARD), (parse_address("fe80::7"), b"\x02\0\0\0\0\x08"), None]


def test_mutated_neighbor_dumps_are_parsed_safely():
    chance, good = random.Random(8), entry("192.0.2.1") + entry("fe80::7") + DONE
    for _ in range(3000):
        data = bytearray(good)
        for _ in range(chance.randrange(1, 9)):
            data[chance.randrange(len(data))] = chance.randrange(256)
        found = list(parse_neighbours(bytes(data[: chance.randrange(len(data))])))
        assert len(found) <= 3


def test_own_and_unknown_addresses_have_no_card():
    assert asyncio.run(ArpTable(b"s").card_of(parse_address("127.0.0.1"))) == ""
    assert asyncio.run(ArpTable(b"s").card_of(parse_address("203.0.113.99"))) == ""


HALL = """
    set -e
    ip link set lo up
    unshare -n sleep 60 & other=$!
    unshare -n sleep 60 & third=$!
    trap "kill $other $third" EXIT
    own=$(readlink /proc/self/ns/net)
    for one in $other $third; do while [ "$(readlink /proc/$one/ns/net)" = "$own" ]; do sleep 0.05; done; done
    ip link add name va type veth peer name vb netns $other
    ip addr add 10.9.0.1/24 dev va; ip addr add fd00:9::1/64 dev va nodad; ip link set va up
    inside() { nsenter -t $other -n "$@"; }
    for k in 2 3 4 5; do inside ip addr add 10.9.0.$k/24 dev vb; done
    inside ip addr add fd00:9::2/64 dev vb nodad; inside ip link set vb up
    inside ip link add link vb name vc netns $third type macvlan mode bridge
    nsenter -t $third -n ip addr add 10.9.0.9/24 dev vc; nsenter -t $third -n ip link set vc up
    for x in 10.9.0.2 10.9.0.3 10.9.0.9 fd00:9::2; do (exec 3<>/dev/tcp/$x/9) 2>/dev/null || true; done
    {python} -m tests.control.audience.test_arp_table
"""


@pytest.mark.long
@pytest.mark.skipif(
    not all(map(shutil.which, ("unshare", "nsenter", "ip")))
    or subprocess.run(["unshare", "-Urn", "true"], capture_output=True, check=False).returncode != 0,
    reason="needs user and network namespaces",
)
def test_addresses_of_one_machine_share_a_card():
    script = textwrap.dedent(HALL).replace("{python}", sys.executable)
    done = subprocess.run(
        ["unshare", "-Urn", "bash", "-c", script], capture_output=True, text=True, timeout=60, check=False,
        env={**os.environ, "PYTHONPATH": os.getcwd()},
    )  # fmt: skip
    if "Operation not" in done.stderr or "Unknown device type" in done.stderr:
        pytest.skip(f"no virtual networks here: {done.stderr[-200:]}")
    assert done.returncode == 0, done.stderr
    cards = dict(line.split("=") for line in done.stdout.split())
    assert cards["10.9.0.2"] == cards["10.9.0.3"] == cards["fd00:9::2"] != "", done.stderr
    assert cards["10.9.0.9"] not in ("", cards["10.9.0.2"])
    assert cards["10.9.0.77"] == ""


async def _print_cards():
    neighbours = ArpTable(b"s")
    for text in ("10.9.0.2", "10.9.0.3", "10.9.0.9", "fd00:9::2", "10.9.0.77"):
        print(f"{text}={(await neighbours.card_of(parse_address(text))).replace(' ', '')}")


if __name__ == "__main__":
    asyncio.run(_print_cards())
