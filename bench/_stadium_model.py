"""A discrete-event model of phones, gateways and the reducer, fed with measured costs.

Phones send at the told rate over a network with jitter and loss (TCP: a lost packet comes after a time-out, and later
ones wait for it). A gateway is one server with a queue: messages, ticks, and frames of the stage in batches. All
gateways are alike, so one is simulated, message by message. What it tells in a tick goes over a link to the reducer,
again one server: it decodes each sketch and reduces once per tick. Then the show waits for its tick and its picture.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float64
from live.clock.ticks import TICK
from live.control.audience.broadcaster import BATCH_PAUSE, BATCH_SIZE, MOST_FRAMES, MOST_MESSAGES, touch_seconds
from live.control.audience.stage_lights import STAGE_EVERY
from live.control.audience.voice_sketch import MAX_SKETCH_BYTES
from live.control.shards.reduction import MAX_SHARDS

SECONDS: Final = 4.0
MOST_OF_GATEWAY: Final = 10_000
"""Phones that one gateway was seen to hold."""
BUSY: Final = 0.6
"""A process is loaded so far at most, to have room for joins and for the phones of another that dies."""
PINGS_PER_SECOND: Final = 8.0 / 15.0
HEADERS: Final = 52 + 22 + 6
"""Bytes of TCP/IP with time stamps, TLS and WebSocket around each message."""
TOUCH_BYTES: Final = 6
LINK_DELAY: Final = 0.0005
LINK_JITTER: Final = 0.005
LINK_LOSS: Final = 0.01
"""Between gateways and reducer: as in the bench's network namespaces."""
SHOW_DELAY: Final = 1.0 / 60.0 + 0.030
"""From the tick that hears a voice to its light: a picture, and a projector's delay [s]."""


@dataclass(frozen=True, slots=True)
class Costs:
    """Processor times [s] of a gateway and the reducer, and sizes."""

    message: float
    """Of a phone's message."""
    frame: float
    """Of a frame of the stage to one phone."""
    idle: float
    """Cores that a gateway takes besides."""
    decode: float
    """Of a gateway's sketch at the reducer."""
    reduce: float
    """Of a tick of the reducer."""
    frame_bytes: float


@dataclass(frozen=True, slots=True)
class Network:
    """A network of phones: median delay in one direction [s], its spread (sigma of a log-normal), loss, and the
    time-out after which TCP sends again [s] (RFC 6298: 0.2 s at least on Linux)."""

    delay: float
    spread: float
    loss: float
    timeout: float


NETWORKS: Final = {
    "here": Network(0.0001, 0.3, 0.0, 0.2),
    "Wi-Fi": Network(0.005, 0.9, 0.01, 0.22),
    "cellular": Network(0.035, 0.6, 0.02, 0.35),
}
"""Loopback; a full hall's Wi-Fi; a cellular network with a stadium in one cell."""


@dataclass(frozen=True, slots=True)
class Found:
    """Predictions: medians and 99th percentiles [s], cores, messages and bits per second."""

    delay: tuple[float, float]
    """From a touch to its light."""
    wait: tuple[float, float]
    """Of a message at the gateway."""
    gateway: float
    reducer: float
    rate: float
    up: float
    down: float
    link: float


def interval(phones: int, gateways: int) -> float:
    """Return the interval of touches [s] that phones are told."""
    return max(touch_seconds(phones), phones / gateways / MOST_MESSAGES)


def loads(phones: int, gateways: int, costs: Costs) -> tuple[float, float]:
    """Return the cores of a gateway and of the reducer."""
    own = phones / gateways
    messages = own * (1.0 / interval(phones, gateways) + PINGS_PER_SECOND)
    frames = min(own / STAGE_EVERY, MOST_FRAMES)
    return costs.idle + messages * costs.message + frames * costs.frame, (gateways * costs.decode + costs.reduce) / TICK


def gateways_needed(phones: int, costs: Costs) -> int | None:
    """Return the least number of gateways, none of which is loaded beyond `BUSY`; None if there is none."""
    for count in range(1, MAX_SHARDS + 1):
        gateway, reducer = loads(phones, count, costs)
        if reducer > BUSY:
            return None
        if gateway <= BUSY and phones / count <= MOST_OF_GATEWAY:
            return count
    return None


def largest_audience(costs: Costs) -> tuple[int, str]:
    """Return the largest audience [1,000 phones steps], and what breaks beyond it."""
    phones = 1000
    while gateways_needed(phones + 1000, costs) is not None:
        phones += 1000
    _, reducer = loads(phones, MAX_SHARDS, costs)
    if reducer > BUSY:
        return phones, "beyond that the reducer is too slow for so many gateways"
    return phones, f"beyond that a gateway has more than {MOST_OF_GATEWAY:,} phones, or too many messages"


def simulate(phones: int, gateways: int, costs: Costs, network: Network, seed: int = 1) -> Found:
    """Simulate `SECONDS` of the audience."""
    chance, own = np.random.default_rng(seed), max(round(phones / gateways), 1)
    every = interval(phones, gateways)
    sent, arrived = _arrivals(own, every, network, chance)
    _, pinged = _arrivals(own, 1.0 / PINGS_PER_SECOND, network, chance)
    pause = max(STAGE_EVERY, own / MOST_FRAMES)
    batches = np.concatenate([
        begin + BATCH_PAUSE * np.arange(-(-own // BATCH_SIZE)) for begin in np.arange(0.0, SECONDS, pause)
    ])  # fmt: skip
    ticks = np.arange(0.0, SECONDS, TICK)
    jobs = [
        (arrived, costs.message), (pinged, costs.message), (batches, costs.frame * min(own, BATCH_SIZE)),
        (ticks, costs.idle * TICK),
    ]  # fmt: skip
    done_messages, _, _, done_ticks = _serve(jobs)
    wait = done_messages - arrived
    told = _next(done_ticks, done_messages)
    link = _delays(len(done_ticks), Network(LINK_DELAY, 0.5, LINK_LOSS, 0.2), chance)
    link += chance.uniform(0.0, LINK_JITTER, len(link))
    reduced = _reduce(np.maximum.accumulate(done_ticks + link), gateways, costs, chance)
    light = reduced[told] + chance.uniform(0.0, TICK, len(told)) + SHOW_DELAY
    good = (sent > 0.5) & (sent < SECONDS - 1.0)
    gateway, reducer = loads(phones, gateways, costs)
    rate = phones / every + phones * PINGS_PER_SECOND
    frames = phones / pause
    return Found(
        delay=_percentiles((light - sent)[good]), wait=_percentiles(wait[good]), gateway=gateway, reducer=reducer,
        rate=phones / every, up=8.0 * rate * (TOUCH_BYTES + HEADERS),
        down=8.0 * (frames * (costs.frame_bytes + HEADERS) + phones * PINGS_PER_SECOND * (17 + HEADERS)),
        link=8.0 * (MAX_SKETCH_BYTES + HEADERS) / TICK,
    )  # fmt: skip


def _arrivals(count: int, every: float, network: Network, chance: np.random.Generator) -> tuple[Float64, Float64]:
    """Return when messages of so many phones are sent and arrive, in order of sending [s]."""
    each = max(int(SECONDS / every), 1)
    sent = every * np.arange(each) + chance.uniform(0.0, every, (count, 1))
    arrived = np.maximum.accumulate(sent + _delays(sent.size, network, chance).reshape(sent.shape), axis=1)
    order = np.argsort(sent.ravel(), kind="stable")
    return sent.ravel()[order], arrived.ravel()[order]


def _delays(count: int, network: Network, chance: np.random.Generator) -> Float64:
    """Return delays in one direction [s]: a lost packet is sent again after a time-out that doubles each time."""
    found = network.delay * np.exp(network.spread * chance.standard_normal(count))
    lost, timeout = chance.random(count) < network.loss, network.timeout
    while lost.any():
        found[lost] += timeout
        timeout *= 2.0
        lost &= chance.random(count) < network.loss
    return found


def _serve(jobs: list[tuple[Float64, float]]) -> list[Float64]:
    """Return when each job is done by one server, first come, first served (Lindley's recursion)."""
    at = np.concatenate([when for when, _ in jobs])
    cost = np.concatenate([np.full(len(when), cost) for when, cost in jobs])
    order = np.argsort(at, kind="stable")
    spent = np.cumsum(cost[order])
    done = np.empty(len(at))
    done[order] = spent + np.maximum.accumulate(at[order] - (spent - cost[order]))
    ends = np.cumsum([len(when) for when, _ in jobs])[:-1]
    return np.split(done, ends)


def _next(ticks: Float64, when: Float64) -> npt.NDArray[np.int64]:
    """Return for each moment the first tick after it."""
    found: npt.NDArray[np.int64] = np.minimum(np.searchsorted(ticks, when), len(ticks) - 1).astype(np.int64)
    return found


def _reduce(arrived: Float64, gateways: int, costs: Costs, chance: np.random.Generator) -> Float64:
    """Return when what one gateway told, which arrives then, is in an event for the show [s]."""
    others = [arrived + chance.uniform(-TICK, TICK, len(arrived)) for _ in range(gateways - 1)]
    ticks = np.arange(0.0, SECONDS + 2.0, TICK)
    jobs = [(arrived, costs.decode), *((np.sort(other), costs.decode) for other in others), (ticks, costs.reduce)]
    done = _serve(jobs)
    found: Float64 = done[-1][_next(ticks, done[0])]
    return found


def _percentiles(values: Float64) -> tuple[float, float]:
    middle, high = np.percentile(values, (50, 99))
    return float(middle), float(high)
