// Boxes of the audience's caption: panel, letters, and bars; pixels, y down.
#include "frame.glsl"
uniform ivec2 cell;       // pixels of a letter in the atlas

in vec4 in_box;           // x, y, width, height
in vec3 in_what;          // u, v of a letter in the atlas, and which of them it is; the first of a panel: radius of its
                          // corners [pixels], of a bar: 1 for the leading one

out vec2 texel;
out vec2 inside;          // pixels from the box's corner
flat out vec2 box;
flat out int what;
flat out float first;

void main() {
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    what = int(in_what.z + 0.5);
    first = in_what.x;
    box = in_box.zw;
    inside = corner * box;
    texel = in_what.xy + corner * vec2(cell);
    vec2 device = (in_box.xy + inside) * whole_picture.zw * 2.0 - 1.0;
    gl_Position = part_clip(vec4(device.x, -device.y, 0.0, 1.0));
}
