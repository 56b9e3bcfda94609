"""Tests of join tickets, vouchers, tokens, rate limits and waiting lines."""

import itertools
import random

import pytest

from live.control.audience.join_tickets import LATE_BURST, PAGE_LOAD_SECONDS, VOUCHER_SECONDS, JoinTickets
from live.control.audience.phone_registry import (
    Device,
    Voucher,
    group_number,
    hue_of,
    ticket_key,
    token_of,
    verify_token,
    verify_voucher,
    voucher_text,
)
from live.control.audience.rate_limit import TokenBucket, WaitingLine

SECRET, OTHER = b"a" * 32, b"b" * 32


def tickets(devices=100, shown=30.0, grace=120.0):
    return JoinTickets(SECRET, shown, grace, devices)


def test_code_changes_and_stays_valid_for_grace_period():
    book = tickets()
    key = book.key(1000.0)
    gone = 1020.0  # the 34th ends
    assert len(key) == 12  # 72 bits
    assert book.find(key, 1000.0) == 33
    assert book.key(gone - 0.01) == key != book.key(gone)
    assert book.find(key, gone + 119.0) == 33
    assert book.find(key, gone + 121.0) == -1
    assert book.find(ticket_key(SECRET, 35), 1000.0) == -1  # one to come
    assert book.find(ticket_key(OTHER, 33), 1000.0) == -1
    assert book.find("", 1000.0) == book.find("é" * 12, 1000.0) == -1


def test_code_has_device_limit_and_late_rate_limit():
    book = tickets(devices=7)
    assert sum(book.use(33) for _ in range(50)) == 7
    assert book.use(34)  # the next code has its own
    gone = 1020.0
    assert not any(book.is_rate_limited(33, gone + PAGE_LOAD_SECONDS - 0.1) for _ in range(100))  # pages load slowly
    assert sum(not book.is_rate_limited(33, gone + PAGE_LOAD_SECONDS + 0.1) for _ in range(100)) == LATE_BURST
    for time in range(2000):
        book.use(40 + time)
        book.is_rate_limited(40 + time, 1e6)
    assert len(book._spent) <= 4096
    assert len(book._late) <= 257
    book.expire(1e9)
    assert (book._spent, book._late) == ({}, {})


def test_voucher_is_valid_once_and_cannot_be_forged():
    book = tickets()
    text = book.issue_voucher(33, 1010.0, 1000.0)
    voucher = book.find_voucher(text, 1005.0)
    assert (voucher.ticket, voucher.slot_ms) == (33, 1010_000)
    follows = book.issue_voucher(33, 0.0, 1020.0, voucher.serial)  # she was told again to wait
    assert book.find_voucher(text, 1011.0)
    assert book.find_voucher(text, 1010.0 + VOUCHER_SECONDS + 1.0) is None
    book.redeem(book.find_voucher(follows, 1030.0))
    assert book.find_voucher(follows, 1031.0) is book.find_voucher(text, 1031.0) is None  # all of that one place
    assert book.find_voucher(book.issue_voucher(33, 0.0, 1020.0), 1031.0) is not None
    chance = random.Random(3)
    for _ in range(200):
        at = chance.randrange(len(text))
        forged = text[:at] + chance.choice("0123456789abcXYZ.-_é\0") + text[at + 1 :]
        assert forged == text or verify_voucher(SECRET, forged) is None
    assert verify_voucher(OTHER, text) is None
    assert verify_voucher(SECRET, voucher_text(SECRET, Voucher(1, 2, 3, 4))) == Voucher(1, 2, 3, 4)
    for _ in range(70_000):
        book.redeem(Voucher(1, 0, chance.randrange(10**9), chance.randrange(10**12)))
    assert len(book._used) <= 65_536


def test_token_is_verified_only_with_its_secret():
    chance = random.Random(7)
    for number in (1, 2, 999, 2**31 - 1):
        device = Device(number, 17, group_number(SECRET, "192.0.2.1"))
        token = token_of(SECRET, device)
        assert verify_token(SECRET, token) == device
        assert verify_token(OTHER, token) is None
        for _ in range(50):
            at = chance.randrange(len(token))
            forged = token[:at] + chance.choice("0123456789abcXYZ.-_é\0") + token[at + 1 :]
            assert forged == token or verify_token(SECRET, forged) is None
    good = token_of(SECRET, Device(1))
    for rubbish in (
        "",
        ".",
        "1",
        "1.0.0.",
        "..",
        "-1.0.0.x",
        "0" + good,
        "9" * 300,
        "１.0.0.x",
        "1.0.0.é",
        "1.2.3.4.5",
    ):
        assert verify_token(SECRET, rubbish) is None
    assert group_number(SECRET, "192.0.2.1") != group_number(OTHER, "192.0.2.1")


def test_consecutive_phones_have_distinct_hues():
    hues = [hue_of(number) for number in range(1, 200)]
    for a, b in itertools.pairwise(hues):
        assert min((a - b) % 1000, (b - a) % 1000) > 200
    assert len(set(hues)) > 190


def test_token_bucket_allows_burst_then_rate():
    bucket = TokenBucket(10.0, 20.0)
    assert sum(bucket.try_take(5.0) for _ in range(100)) == 20
    assert sum(bucket.try_take(5.0 + step / 1000) for step in range(1, 2001)) == 20
    assert not bucket.try_take(6.0)  # a clock that goes back gives nothing


def test_waiting_line_admits_burst_then_assigns_waits():
    line, waits = WaitingLine(20.0, 40.0), []
    for _ in range(100):
        waits.append(line.wait(5.0))
        line.reserve(5.0)
    assert waits[:40] == [0.0] * 40
    assert waits[40:] == pytest.approx([(k + 1) / 20.0 for k in range(60)])
    assert line.wait(5.0 + 61 / 20.0) == pytest.approx(0.0, abs=1e-9)
