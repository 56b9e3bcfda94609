"""python -m training.train DATA --out live/clock/tracking/weights.npz --seed S: train the beat network and write it.

The same data and seed give the same weights (on one machine and one version of JAX). See README.md for the recipe.
"""

import argparse
import json
import queue
import threading
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Final

import jax
import jax.numpy as jnp
import numpy as np
import optax

from training import network, validation
from training.examples import Batch, batches
from training.features import Item, read_items, reverse

LANES: Final = 32
FRAMES: Final = 1000
WARM_UP: Final = 60
AVERAGE: Final = 0.995
"""Share of the old in the running mean of the weights, which is what is kept."""
WEIGHT_BEAT: Final = 2.0
"""How much more a frame on a beat counts; a downbeat twice as much more."""
WEIGHT_PHASE: Final = 0.15

PLAIN: Final = (
    *("blues shuffle", "half time rock", "house", "pop loop", "punk", "random compound", "random groove"),
    *("random in three", "random in two", "rock", "rock ballad", "rock in three", "slow twelve-eight"),
    *("swing", "techno"),
)
"""Styles in which the beat is plain to hear: what the first stage learns from."""


@dataclass(frozen=True, slots=True)
class Stage:
    """A stretch of the training under one cosine of the rate."""

    steps: int
    rate: float
    clip: float
    decay: float
    """Adam's second decay."""
    plain: bool
    """Whether only the plain styles are heard."""


STAGES: Final = (Stage(700, 2.5e-3, 1.0, 0.999, True), Stage(1600, 1.5e-3, 0.5, 0.99, False))
"""Few styles first: a hundred varied ones from the start are learned slower."""


def loss(weights: network.Weights, batch: Any, memory: jax.Array) -> tuple[jax.Array, Any]:
    """(loss, (memory after, its parts)): cross-entropy of the classes, squared error of the phases."""
    look, classes, phases, known = batch
    logits, phase, memory = network.forward(weights, look, memory)
    logs = jax.nn.log_softmax(logits)
    both = jnp.logaddexp(logs[..., 1], logs[..., 2])
    any_beat = classes[..., 1] + classes[..., 2]
    weight = 1.0 + WEIGHT_BEAT * any_beat + WEIGHT_BEAT * classes[..., 2]
    full = -(classes * logs).sum(-1)
    only_beats = -(classes[..., 0] * logs[..., 0] + any_beat * both)
    each = jnp.where(known[..., 1] > 0.0, full, only_beats) * weight * known[..., 0]
    entropy = each.sum() / (known[..., 0].sum() + 1.0)
    known_phase = known[network.PAIR - 1 :: network.PAIR]
    error = (phase - phases[network.PAIR - 1 :: network.PAIR]) ** 2
    off = (error[..., :2].sum(-1) * known_phase[..., 2]).sum() / (known_phase[..., 2].sum() + 1.0)
    off_measure = (error[..., 2:].sum(-1) * known_phase[..., 3]).sum() / (known_phase[..., 3].sum() + 1.0)
    return entropy + WEIGHT_PHASE * (off + off_measure), (memory, jnp.stack([entropy, off, off_measure]))


def ahead(source: Iterator[Batch], count: int = 3) -> Iterator[Batch]:
    """The same batches, made in another thread a few ahead."""
    waiting: queue.Queue[Batch] = queue.Queue(count)

    def work() -> None:
        for batch in source:
            waiting.put(batch)

    threading.Thread(target=work, daemon=True).start()
    while True:
        yield waiting.get()


def train(
    items: list[Item],
    held_out: list[Item],
    seed: int,
    stage: Stage,
    weights: network.Weights,
    report_every: int = 250,
    out: Path | None = None,
) -> network.Weights:
    """The weights after a stage that starts from `weights`; the same items and seed give the same."""
    if stage.plain:
        items = [item for item in items if item.style in PLAIN]
    steps = stage.steps
    schedule = optax.warmup_cosine_decay_schedule(0.0, stage.rate, WARM_UP, steps, stage.rate * 0.01)
    optimiser = optax.chain(
        optax.clip_by_global_norm(stage.clip), optax.adamw(schedule, b2=stage.decay, weight_decay=1e-4)
    )
    moments = optimiser.init(weights)
    mean = weights

    @jax.jit  # type: ignore[untyped-decorator, unused-ignore] # typed where JAX is installed
    def update(weights: Any, moments: Any, mean: Any, memory: Any, batch: Any, fresh: Any, number: Any) -> Any:
        memory = jnp.where(fresh[None, :, None], 0.0, memory)
        (_, (memory, parts)), gradient = jax.value_and_grad(loss, has_aux=True)(weights, batch, memory)
        change, moments = optimiser.update(gradient, moments, weights)
        weights = optax.apply_updates(weights, change)
        share = jnp.minimum(AVERAGE, (1.0 + number) / (10.0 + number))
        mean = jax.tree.map(lambda a, b: share * a + (1.0 - share) * b, mean, weights)
        return weights, moments, mean, memory, parts

    memory = network.state(LANES)
    began, told = time.monotonic(), []
    for number, batch in enumerate(ahead(batches(items, LANES, FRAMES, seed))):
        arrays = (batch.look, batch.classes, batch.phases, batch.known)
        weights, moments, mean, memory, parts = update(weights, moments, mean, memory, arrays, batch.fresh, number)
        told.append(np.asarray(parts))
        if number % 25 == 24:
            print(number + 1, f"{time.monotonic() - began:.0f} s", np.round(np.mean(told, 0), 4), flush=True)
            told = []
        last = number + 1 >= steps
        if (number + 1) % report_every == 0 or last:
            print(validation.report(mean, held_out, brief=not last), flush=True)
            if out is not None:
                save(mean, out, {"seed": seed, "stage": asdict(stage), "step": number + 1, "items": len(items)})
        if last:
            break
    return mean


def save(weights: network.Weights, path: Path, facts: dict[str, Any]) -> None:
    """Write the engine's part of the weights as float16, with what made them."""
    kept: dict[str, Any] = {name: np.asarray(value, np.float16) for name, value in weights.items()}
    recipe = {
        "recipe": "training.train",
        "lanes": LANES,
        "frames": FRAMES,
        "average": AVERAGE,
        "span": network.SPAN,
        "stride": network.STRIDE,
        "units": network.UNITS,
        **facts,
    }
    text = np.frombuffer(json.dumps(recipe).encode(), np.uint8)
    partial = path.with_suffix(".part.npz")
    np.savez_compressed(partial, recipe=text, **kept)
    partial.rename(path)


def load(path: Path) -> network.Weights:
    """Weights written by `save`."""
    with np.load(path) as kept:
        return {name: jnp.asarray(kept[name], jnp.float32) for name in kept.files if name != "recipe"}


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", type=Path, nargs="+")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--steps", type=int, help="steps of the second stage")
    parser.add_argument("--rate", type=float, help="highest rate of the second stage")
    parser.add_argument(
        "--start", type=Path, nargs="+", help="go on from these weights, or from their mean, with the second stage only"
    )
    parser.add_argument(
        "--backwards", action="store_true", help="hear all recordings backwards: `weights_backwards.npz`"
    )
    parser.add_argument("--report-every", type=int, default=250)
    options = parser.parse_args()
    items = [item for folder in options.data for item in read_items(folder)]
    if options.backwards:
        items = [reverse(item) for item in items]
    learned, held_out = validation.split(items)
    print(len(learned), "items to learn from,", len(held_out), "held out", flush=True)
    plain, varied = STAGES
    if options.start is None:
        weights = train(learned, held_out, options.seed, plain, network.initial(options.seed), options.report_every)
    else:
        starts = [load(path) for path in options.start]
        weights = {name: sum(start[name] for start in starts) / len(starts) for name in starts[0]}
    if options.steps:
        varied = replace(varied, steps=options.steps)
    if options.rate:
        varied = replace(varied, rate=options.rate)
    train(learned, held_out, options.seed + 1000, varied, weights, options.report_every, options.out)


if __name__ == "__main__":
    main()
