// Noise that all programs share, from 0 to 1 and nearly evenly spread: r, g: soft, b: grain of paper, a: its fibres.
uniform sampler2D noise_map;

// Soft noise of several sizes.
float clouds(vec2 p) { return 0.62 * textureLod(noise_map, p, 0.0).r + 0.38 * textureLod(noise_map, p * 2.7 + 0.31, 0.0).g; }
