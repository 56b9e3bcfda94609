"""Seeded network weights, and a reference network in plain numpy, for the tests."""

import numpy as np
import numpy.typing as npt

from live.clock.tracking.features import BAND_COUNT, BANDS_PER_WINDOW

Arrays = dict[str, npt.NDArray[np.float64]]

SPAN, STRIDE, CHANNELS, DENSE, UNITS = 12, 5, (5, 4), 10, 7


def random_weights(seed: int = 0) -> Arrays:
    """Named arrays of a small network in the format of the training."""
    rng = np.random.default_rng(seed)
    places = [(bands - SPAN) // STRIDE + 1 for bands in BANDS_PER_WINDOW]
    flat = sum(count * channels for count, channels in zip(places, CHANNELS, strict=True))
    shapes: dict[str, tuple[int, ...]] = {"dense_w": (flat, DENSE), "dense_b": (DENSE,)}
    for ear, channels in enumerate(CHANNELS):
        shapes |= {f"ear{ear}_w": (2 * SPAN, channels), f"ear{ear}_b": (channels,)}
    for layer, size in enumerate((2 * DENSE, UNITS)):
        shapes |= {f"gru{layer}_x": (size, 3 * UNITS), f"gru{layer}_b": (3 * UNITS,)}
        shapes |= {f"gru{layer}_h": (UNITS, 3 * UNITS), f"gru{layer}_c": (UNITS,)}
    shapes |= {"head_w": (2 * UNITS, 6), "head_b": (6,)}
    return {name: rng.normal(0.0, 0.5, shape) for name, shape in shapes.items()}


def reference(arrays: Arrays, looks: npt.NDArray[np.float32]) -> npt.NDArray[np.float64]:
    """Probabilities of nothing, beat, downbeat (frames, 3), from looks (frames, 2 bands); frames must be even."""
    dense = []
    for look in looks.astype(np.float64):
        flat, first = [], 0
        for ear, bands in enumerate(BANDS_PER_WINDOW):
            for place in range(0, bands - SPAN + 1, STRIDE):
                at = first + place
                seen = np.concatenate([look[at : at + SPAN], look[BAND_COUNT + at : BAND_COUNT + at + SPAN]])
                flat.append(np.maximum(seen @ arrays[f"ear{ear}_w"] + arrays[f"ear{ear}_b"], 0.0))
            first += bands
        dense.append(np.maximum(np.concatenate(flat) @ arrays["dense_w"] + arrays["dense_b"], 0.0))
    memory = [np.zeros(UNITS), np.zeros(UNITS)]
    out = []
    for pair in range(0, len(dense) - 1, 2):
        below = np.concatenate(dense[pair : pair + 2])
        for layer in range(2):
            asked = np.split(below @ arrays[f"gru{layer}_x"] + arrays[f"gru{layer}_b"], 3)
            recalled = np.split(memory[layer] @ arrays[f"gru{layer}_h"], 3)
            update = 1.0 / (1.0 + np.exp(-asked[0] - recalled[0]))
            reset = 1.0 / (1.0 + np.exp(-asked[1] - recalled[1]))
            new = np.tanh(asked[2] + reset * (recalled[2] + arrays[f"gru{layer}_c"]))
            below = memory[layer] = (1.0 - update) * new + update * memory[layer]
        logits = (np.concatenate(memory) @ arrays["head_w"] + arrays["head_b"]).reshape(2, 3)
        out.append(np.exp(logits) / np.exp(logits).sum(axis=1, keepdims=True))
    return np.concatenate(out)
