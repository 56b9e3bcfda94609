// One square of the floor map for each element that acts around a point; the others get none.
#include "frame.glsl"
#include "element_light.glsl"

in vec4 in_element;   // x, z [m], kind, level
in vec4 in_form;      // radius [m], first corner, number of corners, way and kind of a flow

out vec2 offset;
flat out int kind;
flat out float level;
flat out float radius;
flat out float flow;
flat out vec3 ember;

// Each ember has its own warmth, and glimmers in its own time.
vec3 ember_at(vec2 home) {
    float own = hash(home.x * 3.1 + home.y * 7.7);
    float glimmer = 0.78 + 0.22 * sin(6.2831853 * (beat * (0.25 + 0.125 * floor(own * 3.0)) + own));
    return mix(vec3(1.0, 0.34, 0.12), vec3(1.0, 0.66, 0.30), own) * glimmer;
}

// A phone's own colour, as bright as others whatever its hue.
vec3 hue_at(float hue) {
    vec3 pure = clamp(abs(fract(hue + vec3(0.0, 2.0, 1.0) / 3.0) * 6.0 - 3.0) - 1.0, 0.0, 1.0);
    vec3 colour = mix(vec3(1.0), pure, 0.85);
    return colour / max(dot(colour, vec3(0.3, 0.5, 0.2)), 0.3) * 0.6;
}

float reach_of() {
    bool point = in_form.z < 1.5 && in_form.x <= 0.0;
    if (kind == ATTRACTOR || kind == REPULSOR) return point ? 1.9 : 0.0;
    if (kind == SPREADER) return 3.2;
    if (kind == VOICE) return 0.5;
    if (kind == PHONE) return 0.9;
    int turning = int(abs(in_form.w) + 0.5) - 1;
    if (kind == FLOW && (turning == RADIAL || turning == VORTEX)) return in_form.x > 0.0 ? in_form.x + 0.5 : 3.4;
    return 0.0;
}

void main() {
    kind = int(in_element.z + 0.5);
    level = in_element.w;
    radius = in_form.x;
    flow = in_form.w;
    ember = kind == PHONE ? hue_at(in_form.y) : ember_at(in_element.xy);
    vec2 corner = vec2((gl_VertexID & 1) == 0 ? -1.0 : 1.0, gl_VertexID < 2 ? -1.0 : 1.0);
    offset = corner * reach_of();
    gl_Position = vec4((in_element.xy + offset) / stage.zw, 0.0, 1.0);
}
