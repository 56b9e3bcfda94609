"""From a thousand to a million phones: how many gateways, what bandwidth, which delay from touch to light.

A discrete-event model, fed with the costs that real sockets have on this machine: `_stadium_model` says how. It is
checked against the largest load that fits here.
"""

from pathlib import Path

import numpy as np
import psutil

from bench._cluster_shards import Load, real_load, shard_rows
from bench._stadium_model import NETWORKS, Costs, Found, gateways_needed, largest_audience, simulate
from live.cli.bench import Row

AUDIENCES = (1_000, 10_000, 100_000, 1_000_000)


def run(full: bool, shared: Path | None) -> list[Row]:
    """Rows of gateways that share an audience, the model's predictions, and their check."""
    rows = shard_rows(full)
    reduce_ms = next(row.value or 0.0 for row in rows if "reduced" in row.name)
    loads = [real_load(1, 800, 5.0, rate, stage=stage) for rate, stage in ((10.0, False), (2.0, False), (2.0, True))]
    costs = costs_of(loads, reduce_ms / 1e3)
    rows.append(
        Row("a gateway's processor time for a message alone", 1e6 * costs.message, "us", 17.0,
            peers={"a frame of the stage [us]": 1e6 * costs.frame, "else, cores": costs.idle})
    )  # fmt: skip
    return [*rows, *check_rows(costs, full), *prediction_rows(costs)]


def costs_of(loads: list[Load], reduce: float) -> Costs:
    """Return the costs from three loads: many messages, few, and few with the stage. `reduce`: of 16 gateways [s]."""
    many, few, staged = loads
    message = max((many.gateways - few.gateways) / max(many.rate - few.rate, 1.0), 1e-6)
    sent = staged.frames * staged.joined
    frame = max((staged.gateways - few.gateways - message * (staged.rate - few.rate)) / max(sent, 1.0), 1e-6)
    return Costs(
        message=message, frame=frame, idle=max(few.gateways - message * few.rate, 0.0),
        decode=reduce / 32.0, reduce=reduce / 2.0, frame_bytes=max(staged.frame_bytes, 1.0),
    )  # fmt: skip


def check_rows(costs: Costs, full: bool) -> list[Row]:
    """The largest load that fits here against its prediction, for the messages and frames that were really sent."""
    phones = 8_000 if full else 3_000
    load = real_load(1, phones, 10.0 if full else 5.0)
    predicted = costs.idle + costs.message * load.rate + costs.frame * load.frames * load.joined
    found, network = simulate(phones, 1, costs, NETWORKS["here"]), 2e3 * NETWORKS["here"].delay
    return [
        Row(f"{phones:,} phones at one gateway: processor time, apart from the prediction",
            100.0 * abs(load.gateways / predicted - 1.0), "%", 30.0,
            peers={"cores, measured": load.gateways, "predicted": predicted, "phones in": load.joined}),
        Row(f"{phones:,} phones at one gateway: messages a second that came, of those predicted",
            100.0 * load.rate / found.rate, "%",
            peers={"frames of the stage that came [1/s]": load.frames, "the phones' own cores": load.phones_cpu,
                   "load average": psutil.getloadavg()[0]}),
        Row(f"{phones:,} phones at one gateway: a ping there and back, median", load.trips[0], "ms",
            peers={"predicted": network + 1e3 * found.wait[0], "p99": load.trips[1],
                   "predicted p99": network + 1e3 * found.wait[1]},
            note="the phones share the gateway's cores here, which the prediction does not know"),
    ]  # fmt: skip


def prediction_rows(costs: Costs) -> list[Row]:
    """What an audience needs, and where it breaks."""
    rows = []
    for phones in AUDIENCES:
        count = gateways_needed(phones, costs)
        if count is None:
            rows.append(Row(f"{phones:,} phones: gateways", None, "", note="more than 64 gateways, or one reducer"))
            continue
        found: dict[str, Found] = {
            name: simulate(phones, count, costs, network) for name, network in NETWORKS.items() if name != "here"
        }
        one = next(iter(found.values()))
        peers = {
            f"touch to light, {name}, {what} [ms]": 1e3 * value
            for name, each in found.items() for what, value in zip(("median", "p99"), each.delay, strict=True)
        }  # fmt: skip
        rows.append(
            Row(f"{phones:,} phones: gateways", count, "",
                peers={**peers, "a gateway's cores": one.gateway, "the reducer's cores": one.reducer,
                       "messages/s of a phone": one.rate / phones, "in [Mbit/s]": one.up / 1e6,
                       "out [Mbit/s]": one.down / 1e6, "of a gateway to the reducer [Mbit/s]": one.link / 1e6})
        )  # fmt: skip
    most, why = largest_audience(costs)
    return [*rows, Row("phones that 64 gateways and one reducer carry", most, "", note=why)]


def main() -> None:
    """For those who look at the model alone: with costs as of two cores of 2024."""
    for row in prediction_rows(Costs(17e-6, 9e-6, 0.05, 5e-5, 7e-4, 78.0)):
        print(row.name, row.value, {name: np.round(value, 2) for name, value in row.peers.items()}, row.note)


if __name__ == "__main__":
    main()
