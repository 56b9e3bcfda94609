// A rectangle of the floor map around each item of the set: a disc, or a wall between two points.
#include "frame.glsl"

in vec4 in_ends;   // x, z, x, z [m]
in vec2 in_form;   // radius [m], 1 for the set, 0 for a real dancer

out vec2 place;
flat out vec4 ends;
flat out vec2 form;

void main() {
    ends = in_ends;
    form = in_form;
    float reach = in_form.x + 0.6;
    vec2 corner = vec2((gl_VertexID & 1) == 0 ? 0.0 : 1.0, gl_VertexID < 2 ? 0.0 : 1.0);
    place = mix(min(ends.xy, ends.zw) - reach, max(ends.xy, ends.zw) + reach, corner);
    gl_Position = vec4(place / stage.zw, 0.0, 1.0);
}
