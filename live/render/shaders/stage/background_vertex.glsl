// A rectangle on the wall behind the stage, its image in the floor, or the whole picture at the far plane.
#include "frame.glsl"
uniform vec4 wall;        // half width, bottom, height, z [m]; all 0: the whole picture
uniform vec2 crop;        // how much of the picture's width and height is seen
uniform int mirrored;     // 1: in the floor

out vec2 texel;
out vec2 inside;
out float up;             // above the floor [m]

void main() {
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    inside = corner;
    texel = vec2(0.5) + (vec2(corner.x, 1.0 - corner.y) - 0.5) * crop;
    up = wall.y + corner.y * wall.z;
    float y = mirrored == 1 ? -up : up;
    gl_Position = wall.z > 0.0 ? world_to_clip * vec4((corner.x * 2.0 - 1.0) * wall.x, y, wall.w, 1.0)
                               : vec4(corner * 2.0 - 1.0, 1.0, 1.0);
}
