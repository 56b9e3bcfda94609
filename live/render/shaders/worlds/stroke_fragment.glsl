#include "frame.glsl"
#include "finish.glsl"
#include "shown.glsl"

in vec3 across;
flat in vec4 light;
out vec4 shown;

void main() {
    float along = max(max(-across.x, across.x - across.z), 0.0);
    float off = length(vec2(along, across.y));
    float core = 1.0 - smoothstep(0.16, 0.46, off), halo = square(max(1.0 - off, 0.0));
    vec3 colour = mix(light.rgb, vec3(1.0), 0.35) * (core * 1.15) + light.rgb * (halo * 0.42);
    shown = laid_over(colour * light.a, 0.0);
}
