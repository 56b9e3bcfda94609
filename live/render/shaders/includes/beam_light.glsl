// Light of the beams before a surface, where surfaces add it themselves: see `BeamPass.within`.
uniform sampler2D beam_map;   // light in the haze, of the whole picture
uniform int beams;            // 1: to be added here
const float BEFORE_DANCERS = 0.45;   // mean share of a beam's light before a dancer, who hides the rest

// Adds as blending in the compressed range does: a + b + ab. A loop that does not run costs next to nothing.
vec3 beams_over(vec3 light, vec2 at, float share) {
    for (int k = 0; k < beams; ++k) light += textureLod(beam_map, at, 0.0).rgb * share * (1.0 + light);
    return light;
}
