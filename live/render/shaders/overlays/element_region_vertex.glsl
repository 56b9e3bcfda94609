// A rectangle of the floor map around each line or region that attracts or repels, and each drawn flow.
#include "frame.glsl"
#include "element_corners.glsl"

in vec4 in_element;   // x, z [m], kind, level
in vec4 in_form;      // radius [m], first corner, number of corners, way and kind of a flow

out vec2 place;
flat out int kind;
flat out float level;
flat out float radius;
flat out ivec2 range;    // first corner, pieces
flat out int closed;
flat out vec2 home;
flat out float way;

void main() {
    kind = int(in_element.z + 0.5);
    level = in_element.w;
    radius = in_form.x;
    home = in_element.xy;
    way = sign(in_form.w);
    int first = int(in_form.y + 0.5), count = int(in_form.z + 0.5);
    range = ivec2(first, max(count - 1, 0));
    vec2 low = home, high = home;
    for (int i = first; i < first + count; ++i) {
        low = min(low, corners[i].xy);
        high = max(high, corners[i].xy);
    }
    closed = count > 3 && corners[first].xy == corners[first + count - 1].xy ? 1 : 0;
    bool mine = (kind == ATTRACTOR || kind == REPULSOR) && (count > 1 || radius > 0.0);
    mine = mine || (kind == FLOW && count > 1 && int(abs(in_form.w) + 0.5) - 1 == DRAWN);
    float reach = mine ? radius + 1.2 : 0.0;
    vec2 corner = vec2((gl_VertexID & 1) == 0 ? 0.0 : 1.0, gl_VertexID < 2 ? 0.0 : 1.0);
    place = mine ? mix(low - reach, high + reach, corner) : home;
    gl_Position = vec4(place / stage.zw, 0.0, 1.0);
}
