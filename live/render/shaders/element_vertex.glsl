// One square of the floor map for each element in force.
#include "frame.glsl"

in vec4 in_element;   // x, z [m], kind, level

out vec2 offset;
flat out float kind;
flat out float level;

void main() {
    float reach = in_element.z > 1.5 ? 3.2 : 1.9;
    vec2 corner = vec2((gl_VertexID & 1) == 0 ? -1.0 : 1.0, gl_VertexID < 2 ? -1.0 : 1.0);
    offset = corner * reach;
    kind = in_element.z;
    level = in_element.w;
    gl_Position = vec4((in_element.xy + offset) / stage.zw, 0.0, 1.0);
}
