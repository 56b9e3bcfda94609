"""The network in JAX, as it is trained; the engine's own form is
`live/clock/tracking/beat_network.py`, held equal by tests.

Frames pass through filters along frequency (one ear at a time), a dense layer, two gated recurrent layers (Cho et
al., 2014, in the form with the reset after the product), and heads. Only the first head (nothing, beat, downbeat) is
kept for the engine; the others (phase in the beat and in the measure) teach the layers below to count along.
The recurrent layers take two frames at a time: half the steps, and half the way to what was two measures ago.
"""

from typing import Any, Final

import jax
import jax.numpy as jnp
import numpy as np

from live.clock.tracking.features import BAND_COUNT, BANDS_PER_WINDOW

Weights = dict[str, Any]

SPAN: Final = 12
"""Bands that one filter sees."""
STRIDE: Final = 5
"""Bands from one filter's place to the next."""
CHANNELS: Final = (16, 12)
"""Filters of each ear."""
DENSE: Final = 64
UNITS: Final = 80
LAYERS: Final = 2
CLASSES: Final = 3
PHASES: Final = 4
PAIR: Final = 2
"""Frames that the recurrent layers take at a time."""


def places(bands: int) -> int:
    """How many places along `bands` bands a filter takes."""
    return (bands - SPAN) // STRIDE + 1


def initial(seed: int) -> Weights:
    """Fresh weights from a seed."""
    rng = np.random.default_rng(seed)

    def matrix(rows: int, columns: int, gain: float = 1.0) -> jax.Array:
        return jnp.asarray(rng.normal(0.0, gain / np.sqrt(rows), (rows, columns)), jnp.float32)

    def orthogonal(size: int) -> np.ndarray:
        q, r = np.linalg.qr(rng.normal(size=(size, size)))
        return q * np.sign(np.diag(r))

    weights: Weights = {}
    flat = 0
    for ear, (bands, channels) in enumerate(zip(BANDS_PER_WINDOW, CHANNELS, strict=True)):
        weights[f"ear{ear}_w"] = matrix(2 * SPAN, channels, 1.4)
        weights[f"ear{ear}_b"] = jnp.zeros(channels)
        flat += places(bands) * channels
    weights["dense_w"] = matrix(flat, DENSE, 1.4)
    weights["dense_b"] = jnp.zeros(DENSE)
    size = PAIR * DENSE
    for layer in range(LAYERS):
        weights[f"gru{layer}_x"] = matrix(size, 3 * UNITS)
        weights[f"gru{layer}_h"] = jnp.asarray(np.concatenate([orthogonal(UNITS) for _ in range(3)], 1), jnp.float32)
        bias = np.zeros(3 * UNITS)
        bias[:UNITS] = np.log(np.exp(rng.uniform(0.0, np.log(100.0), UNITS)) + 1e-3)  # memories from 1 to 100 pairs
        weights[f"gru{layer}_b"] = jnp.asarray(bias, jnp.float32)
        weights[f"gru{layer}_c"] = jnp.zeros(UNITS)
        size = UNITS
    weights["head_w"] = matrix(LAYERS * UNITS, PAIR * CLASSES, 0.3)
    weights["head_b"] = jnp.asarray([2.0, -1.0, -2.0] * PAIR, jnp.float32)
    weights["phase_w"] = matrix(LAYERS * UNITS, PHASES, 0.3)
    weights["phase_b"] = jnp.zeros(PHASES)
    return weights


def state(count: int) -> jax.Array:
    """The memory before any music, shape (layers, count, units)."""
    return jnp.zeros((LAYERS, count, UNITS))


def front(weights: Weights, look: jax.Array) -> jax.Array:
    """From what is seen of frames, shape (..., 2 bands), to the dense layer's output, shape (..., DENSE)."""
    level, rise = look[..., :BAND_COUNT], look[..., BAND_COUNT:]
    found, first = [], 0
    for ear, bands in enumerate(BANDS_PER_WINDOW):
        index = first + np.arange(places(bands))[:, None] * STRIDE + np.arange(SPAN)[None, :]
        seen = jnp.concatenate([level[..., index], rise[..., index]], axis=-1)
        out = jax.nn.relu(seen @ weights[f"ear{ear}_w"] + weights[f"ear{ear}_b"])
        found.append(out.reshape(*out.shape[:-2], -1))
        first += bands
    return jax.nn.relu(jnp.concatenate(found, -1) @ weights["dense_w"] + weights["dense_b"])


@jax.custom_vjp  # type: ignore[untyped-decorator, unused-ignore] # typed where JAX is installed
def gru(wh: jax.Array, c: jax.Array, xi: jax.Array, h0: jax.Array) -> jax.Array:
    """Gated recurrent layer over time: xi (T, B, 3 U) is the input's share, h0 (B, U); returns (T, B, U)."""
    return _gru_forward(wh, c, xi, h0)[0]


def _gru_forward(wh: jax.Array, c: jax.Array, xi: jax.Array, h0: jax.Array) -> tuple[jax.Array, Any]:
    units = h0.shape[-1]

    def step(h: jax.Array, x: jax.Array) -> tuple[jax.Array, Any]:
        g = h @ wh
        gates = jax.nn.sigmoid(x[:, : 2 * units] + g[:, : 2 * units])
        z, r = gates[:, :units], gates[:, units:]
        a = g[:, 2 * units :] + c
        n = jnp.tanh(x[:, 2 * units :] + r * a)
        new = n + z * (h - n)
        return new, (new, gates, a, n)

    _, (out, gates, a, n) = jax.lax.scan(step, h0, xi)
    return out, (wh, h0, out, gates, a, n)


def _gru_backward(kept: Any, d_out: jax.Array) -> tuple[jax.Array, ...]:
    wh, h0, out, gates, a, n = kept
    units = h0.shape[-1]
    before = jnp.concatenate([h0[None], out[:-1]], 0)
    wt = wh.T

    def step(dh: jax.Array, at: Any) -> tuple[jax.Array, Any]:
        d, h, g, a_t, n_t = at
        z, r = g[:, :units], g[:, units:]
        dh = dh + d
        dn = dh * (1.0 - z) * (1.0 - n_t * n_t)
        dz = dh * (h - n_t) * z * (1.0 - z)
        dr = dn * a_t * r * (1.0 - r)
        da = dn * r
        dg = jnp.concatenate([dz, dr, da], -1)
        return dh * z + dg @ wt, (dg, dn)

    dh0, (dg, dn) = jax.lax.scan(step, jnp.zeros_like(h0), (d_out, before, gates, a, n), reverse=True)
    d_wh = before.reshape(-1, units).T @ dg.reshape(-1, 3 * units)
    d_c = dg[..., 2 * units :].sum((0, 1))
    d_xi = jnp.concatenate([dg[..., : 2 * units], dn], -1)
    return d_wh, d_c, d_xi, dh0


gru.defvjp(_gru_forward, _gru_backward)


def forward(weights: Weights, look: jax.Array, memory: jax.Array) -> tuple[jax.Array, jax.Array, jax.Array]:
    """(class logits (T, B, 3), phases (T / 2, B, 4), memory after) for look (T, B, 2 bands), memory (layers, B, U)."""
    x = front(weights, look)
    count, lanes = look.shape[:2]
    x = x.reshape(count // PAIR, PAIR, lanes, DENSE).swapaxes(1, 2).reshape(count // PAIR, lanes, PAIR * DENSE)
    outs, after = [], []
    for layer in range(LAYERS):
        xi = x @ weights[f"gru{layer}_x"] + weights[f"gru{layer}_b"]
        x = gru(weights[f"gru{layer}_h"], weights[f"gru{layer}_c"], xi, memory[layer])
        outs.append(x)
        after.append(x[-1])
    both = jnp.concatenate(outs, -1)
    logits = (both @ weights["head_w"] + weights["head_b"]).reshape(count // PAIR, lanes, PAIR, CLASSES)
    phases = both @ weights["phase_w"] + weights["phase_b"]
    return logits.swapaxes(1, 2).reshape(count, lanes, CLASSES), phases, jnp.stack(after)
