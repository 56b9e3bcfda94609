// Where the lamps of the beams hang, and where they look, now.
const int LAMPS = 8;
const float TAU = 6.2831853;

float beam_side(int k) { return (float(k) - 3.5) / 3.5; }
vec3 beam_lamp(int k) { return vec3(beam_side(k) * (stage.x * 0.95 + 0.4), 7.2, -stage.y * 0.75); }

// Where it meets the floor.
vec2 beam_foot(int k) {
    float turn = TAU * (beam_light.w / 8.0 + float(k) * 0.125);
    vec2 foot = vec2(beam_side(k) * stage.x * 1.1 * light_beams_fan(), stage.y * (0.35 - 0.25 * abs(beam_side(k))));
    return foot + light_beams_sway() * vec2(sin(turn) * stage.x * 0.55, cos(turn * 0.5) * stage.y * 0.55);
}

vec3 beam_tint(int k) {
    return (k & 1) == 0 ? beam_light.rgb : mix(beam_light.rgb, key_light.rgb * light_beams(), 0.55);
}

float beam_answer() { return 1.0 + 3.0 * light_pulse() * key_direction.w; }

// Their light before a surface, where surfaces add it themselves: see `BeamPass.within`.
uniform sampler2D beam_map;   // light in the haze, of the whole picture
uniform int beams;            // 1: to be added here
const float BEFORE_DANCERS = 0.45;   // mean share of a beam's light before a dancer, who hides the rest

// Adds as blending in the compressed range does: a + b + ab. A loop that does not run costs next to nothing.
vec3 beams_over(vec3 light, vec2 at, float share) {
    for (int k = 0; k < beams; ++k) light += textureLod(beam_map, at, 0.0).rgb * share * (1.0 + light);
    return light;
}
