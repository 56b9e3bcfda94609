"""Client addresses of requests, with and without proxies, and the grouping of addresses."""

import random

import pytest

from live.control.audience.client_address import Proxies, group_of, parse_address

PROXIES = Proxies(["127.0.0.1", "10.0.0.0/8", "2001:db8:ffff::/48"])


def group(text):
    return group_of(parse_address(text))


def test_ipv6_addresses_group_by_64_and_mapped_addresses_by_ipv4():
    assert group("2001:db8:1:2::1") == group("2001:db8:1:2:ffff:eeee:dddd:cccc") == "2001:db8:1:2::/64"
    assert group("2001:db8:1:3::1") != group("2001:db8:1:2::1")
    assert group("::ffff:192.0.2.7") == group("192.0.2.7") == group("192.0.2.7:4711") == "192.0.2.7"
    assert group("192.0.2.8") != group("192.0.2.7")
    assert group("fe80::1%wlan0") == group("[fe80::2]:80") == "fe80::/64"
    for rubbish in ("", "x", "1.2.3", "1.2.3.4.5", "[::1", "_hidden", "unknown", "1.2.3.4:x", "é", "::g"):
        assert parse_address(rubbish) is None
    assert group_of(None) == ""


@pytest.mark.parametrize(
    ("peer", "forwarded_for", "forwarded", "whose"),
    [
        ("198.51.100.9", ["203.0.113.5"], [], "198.51.100.9"),  # nobody named it: what it says is nothing
        ("198.51.100.9", [], ["for=203.0.113.5"], "198.51.100.9"),
        ("127.0.0.1", [], [], "127.0.0.1"),
        ("127.0.0.1", ["203.0.113.5"], [], "203.0.113.5"),
        ("::ffff:127.0.0.1", ["203.0.113.5:4711"], [], "203.0.113.5"),
        ("127.0.0.1", ["1.1.1.1, 203.0.113.5"], [], "203.0.113.5"),  # the phone wrote the first itself
        ("127.0.0.1", ["1.1.1.1", "203.0.113.5, 10.1.2.3"], [], "203.0.113.5"),  # two proxies in a row, two headers
        ("127.0.0.1", ["1.1.1.1, 10.9.9.9, 203.0.113.5, 10.1.2.3"], [], "203.0.113.5"),
        ("127.0.0.1", ["10.7.7.7, 10.1.2.3"], [], "10.7.7.7"),  # a phone in the proxies' own network
        ("127.0.0.1", ["203.0.113.5, unknown"], [], "127.0.0.1"),  # the nearest proxy does not know
        ("127.0.0.1", ["203.0.113.5,"], [], "127.0.0.1"),
        ("127.0.0.1", [], ["for=203.0.113.5;proto=https;by=10.0.0.1"], "203.0.113.5"),
        ("127.0.0.1", [], ['for="[2001:db8:1:2::5]:4711", For=10.1.2.3'], "2001:db8:1:2::5"),
        ("127.0.0.1", [], ['for=1.1.1.1;x="a, for=9.9.9.9;", by=10.0.0.1;for="203.0.113.5"'], "203.0.113.5"),
        ("127.0.0.1", [], ["for=203.0.113.5, proto=https"], "127.0.0.1"),
        ("127.0.0.1", [], ["for=_hidden"], "127.0.0.1"),
        ("10.3.3.3", ["203.0.113.5"], ["for=203.0.113.5"], "203.0.113.5"),
        ("10.3.3.3", ["203.0.113.5"], ["for=1.1.1.1"], "10.3.3.3"),  # one of them is the phone's own
        ("2001:db8:ffff::1", ["203.0.113.5"], [], "203.0.113.5"),
    ],
)
def test_forwarded_address_is_accepted_only_from_named_proxies(peer, forwarded_for, forwarded, whose):
    assert str(PROXIES.sender(peer, forwarded_for, forwarded)) == whose
    if peer != "198.51.100.9":
        assert str(Proxies().sender(peer, forwarded_for, forwarded)) == str(parse_address(peer))


@pytest.mark.long
def test_hostile_headers_do_not_spoof_the_client_address():
    chance, parts = (
        random.Random(5),
        ["for=", '"', ",", ";", "\\", "1.2.3.4", " ", "[", "]", "::1", "x=", "é", "10.0.0.1"],
    )
    for _ in range(3000):
        text = "".join(chance.choice(parts) for _ in range(chance.randrange(1, 60)))
        for headers in (([text + ", 203.0.113.5"], []), ([], [text + '", for=203.0.113.5']), ([text], [text])):
            assert PROXIES.sender("127.0.0.1", *headers) is not None
    long = ["1.1.1.1, " * 5000 + "203.0.113.5"]
    assert str(PROXIES.sender("127.0.0.1", long, [])) == "203.0.113.5"
    for bad in ('"' * 8000, "for=" * 2000, 'for="' + "\\" * 7000, ";" * 8000, "," * 8000):
        assert str(PROXIES.sender("127.0.0.1", [], [bad])) == "127.0.0.1"
