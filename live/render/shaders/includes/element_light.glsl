// Colours and profiles that all elements on the floor share.
uniform float texel;   // of the floor map [m]
uniform float beat;    // comes back after 64

const vec3 WARM = vec3(1.0, 0.52, 0.18);
const vec3 COOL = vec3(0.20, 0.55, 1.0);
const vec3 MINT = vec3(0.62, 0.95, 0.72);
const vec3 LILAC = vec3(0.74, 0.62, 1.0);
const vec3 SILVER = vec3(0.50, 0.78, 0.95);
const vec3 PALE = vec3(1.0, 0.86, 0.60);
const float ELEMENT_LIGHT = 0.55;

float bell(float x, float width) { return exp(-square(x / width)); }

// A line must not be thinner than the map can show; what it gains in width it loses in brightness.
float hairline(float x, float width) {
    float shown = max(width, 0.75 * texel);
    return bell(x, shown) * sqrt(width / shown);
}

// Chance from a number, without sines: the same on all drivers (Hoskins, Hash without Sine, 2014).
float hash(float n) {
    n = fract(n * 0.1031);
    n *= n + 33.33;
    return fract(n * (n + n));
}

// Light that runs towards +along in lanes beside each other: heads with long tails, no two lanes alike.
float stream(float along, float lane, float across, float width, float round_trip) {
    float shown = max(width, 0.5 * texel);
    float chance = hash(lane);
    if (abs(across) > 2.5 * shown || hash(lane + 41.0) < 0.30) return 0.0;   // dark between lanes, and some lanes
    float speed = (chance < 0.4 ? 0.25 : (chance < 0.75 ? 0.1875 : 0.3125)) * 2.4 / round_trip;
    speed = max(round(speed * 64.0), 1.0) / 64.0;   // whole round trips in 64 beats
    float q = fract(along / round_trip - beat * speed + hash(lane + 17.0));
    float body = square(q) * q * (1.0 - smoothstep(0.93, 1.0, q));
    return body * bell(across, shown) * (0.5 + 0.5 * chance);
}
