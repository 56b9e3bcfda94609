// A strip of the floor map for each piece of a path, for a crossing, for a uniform flow.
#include "frame.glsl"

in vec4 in_piece;     // its ends: x, z, x, z [m]
in vec4 in_element;   // kind, level, radius [m], way and kind of a flow
in vec4 in_form;      // metres of the line before it, in all, 1 if the line is closed

out vec2 at;          // metres along the line, and beside it
out vec2 place;       // on the stage [m]
flat out vec2 ends;   // where the piece begins and ends along the line
flat out vec2 whole;  // length of the line, 1 if it is closed
flat out int kind;
flat out float level;
flat out float radius;
flat out float way;
flat out int everywhere;

void main() {
    kind = int(in_element.x + 0.5);
    level = in_element.y;
    radius = in_element.z;
    way = sign(in_element.w);
    vec2 a = in_piece.xy, b = in_piece.zw;
    vec2 along = (b - a) / max(distance(a, b), 1e-6), beside = vec2(-along.y, along.x);
    float far = length(stage.zw);
    everywhere = kind == FLOW && radius <= 0.0 ? 1 : 0;
    float before = in_form.x, half_width = kind == PATH ? max(0.3, radius + 0.3) : 1.0;
    if (kind == CROSSING || everywhere == 1) {   // the whole line through both points; along it 0 is before the middle
        vec2 foot = a - along * dot(a, along);
        before = -far;
        half_width = kind == CROSSING ? 1.6 : far;
        if (everywhere == 1) foot = vec2(0.0);
        a = foot - along * far;
        b = foot + along * far;
    } else if (kind == FLOW) {
        half_width = radius + 0.5;
    }
    ends = vec2(before, before + distance(a, b));
    whole = in_form.yz;
    float cap = kind == CROSSING ? 0.0 : half_width;
    at.x = (gl_VertexID & 1) == 0 ? ends.x - cap : ends.y + cap;
    at.y = gl_VertexID < 2 ? -half_width : half_width;
    place = a + along * (at.x - ends.x) + beside * at.y;
    gl_Position = vec4(place / stage.zw, 0.0, 1.0);
}
