"""Motion by example: how long the search takes, offline and live (H023), in seconds of the processor."""

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from bench import texture_speed
from bench._example_case import made_leader, made_units
from live.cli.bench import Row
from live.motion.partner.answer import answer
from live.motion.partner.decoder import Reading, decode
from live.motion.partner.point_clouds import Cloud
from live.motion.partner.refinement import refine
from live.motion.partner.time_scaled_units import make_stretches
from live.motion.partner.units import Units
from live.motion.partner_live.follower_filter import FollowerFilter
from live.motion.partner_live.online_player import LivePartner

STRETCH = 0.15
K = 1.0
BEAMS = (2.0, 5.0, 10.0, 20.0, 40.0)
PUBLISHED = {"Hsu 2004 without beam": 78.0, "Hsu 2004 with beam": 10.0, "Hsu 2004 up-sampling": 2.0,
             "Hsu 2004 afterwards": 26.0}  # fmt: skip


def run(full: bool, shared: Path | None) -> list[Row]:
    """168 units of 0.6 to 1 s, 150 s of a leader; and what the bench texture-speed measures."""
    units = made_units()
    x, _ = made_leader(units)
    textured = [replace(row, name=f"texture, {row.name}") for row in texture_speed.run(full, shared)]
    return [*_offline(units, x, 7.5, 5 if full else 2), *_fast(units, x, full), *_live(units, x, full), *textured]


def timed(work: Callable[[], Any], times: int = 1) -> tuple[Any, float, float]:
    """What comes of it, the least seconds of this thread, and the least by the clock."""
    own, clock, result = [], [], None
    for _ in range(times):
        began, began_own = time.perf_counter(), time.thread_time()
        result = work()
        own.append(time.thread_time() - began_own)
        clock.append(time.perf_counter() - began)
    return result, min(own), min(clock)


def _offline(units: Units, x: Cloud, rate: float, times: int) -> list[Row]:
    def whole() -> Reading:
        thin = x.resampled(rate)
        coarse = decode(thin, make_stretches(units, rate, STRETCH), k=K)
        fine = refine(x, units, coarse, k=K, stretch=STRETCH)
        answer(fine, units, x.count)
        return coarse

    exact, own, clock = timed(whole, times)
    stretches, thin = make_stretches(units, rate, STRETCH), x.resampled(rate)
    _, search, _ = timed(lambda: decode(thin, stretches, k=K), times)
    rows = [
        Row("150 s at 7.5 Hz: everything, without beam", own, "s", 1.0, peers={"by the clock": clock, **PUBLISHED}),
        Row("150 s at 7.5 Hz: search alone, without beam", search, "s", peers={"Hsu 2004": 78.0}),
    ]
    return [*rows, *_beam(stretches, thin, exact, K, "150 s at 7.5 Hz", 0.1, times)]


def _beam(
    stretches: Any, thin: Cloud, exact: Reading | None, k: float, words: str, bar: float, times: int
) -> list[Row]:
    """The narrowest of some beams that gives the score of the widest."""
    best = exact.score if exact is not None else decode(thin, stretches, k=k, beam=BEAMS[-1] * k).score
    for width in BEAMS:
        found, own, clock = timed(partial(decode, thin, stretches, k=k, beam=width * k), times)
        if found.score <= best * (1.0 + 1e-9):
            break
    peers = {"by the clock": clock, "beam": width * k}
    return [
        Row(f"{words}: search with beam, the same row", own, "s", bar, peers=peers),
        Row(f"{words}: score over the best, with beam", float(found.score / best - 1.0), "", 1e-9),
    ]


def _fast(units: Units, x: Cloud, full: bool) -> list[Row]:
    """No down-sampling."""
    rate = 30.0
    stretches, thin = make_stretches(units, rate, STRETCH), x.resampled(rate)
    rows = _beam(stretches, thin, None, K * rate / 7.5, "150 s at 30 Hz", 5.0, 1)
    if full:
        exact, own, _ = timed(lambda: decode(thin, stretches, k=K * rate / 7.5))
        rows.append(Row("150 s at 30 Hz: search without beam", own, "s", peers={"units": float(exact.count)}))
    return rows


def _live(units: Units, x: Cloud, full: bool) -> list[Row]:
    """Frame by frame at 30 Hz, led by the two first points as hips; nothing known of the beat."""
    rate = 30.0
    known = tuple(replace(one, leader=_hips(one.control)) for one in units.examples)
    began = time.thread_time()
    partner = LivePartner(FollowerFilter(replace(units, examples=known), rate=rate))
    learnt = time.thread_time() - began
    thin = _hips(x).resampled(rate)
    spent = []
    for n in range(thin.count if full else min(thin.count, 1500)):
        began = time.thread_time()
        partner.process_frame(thin.floor[n], thin.height[n])
        partner.pose()
        spent.append((time.thread_time() - began) * 1000.0)
    return [
        Row("live at 30 Hz: learning", learnt, "s", 180.0),
        Row("live at 30 Hz: a frame, median", float(np.median(spent)), "ms", 1.0),
        Row("live at 30 Hz: a frame, p99", float(np.percentile(spent, 99)), "ms", 1.5),
    ]


def _hips(x: Cloud) -> Cloud:
    """The cloud with its first two points in front, as if they were hips."""
    order = [0, 1, *range(x.floor.shape[1])]
    return Cloud(np.ascontiguousarray(x.floor[:, order]), np.ascontiguousarray(x.height[:, order]), x.rate)
