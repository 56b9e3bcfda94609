// Instance 0 is the panel, the others are letters; pixels, y down.
#include "frame.glsl"
uniform ivec2 cell;
uniform vec4 panel;       // x, y, width, height

in vec4 in_letter;        // x, y, u, v

out vec2 texel;
flat out int is_panel;

void main() {
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    is_panel = gl_InstanceID == 0 ? 1 : 0;
    vec2 pixel = is_panel == 1 ? panel.xy + corner * panel.zw : in_letter.xy + corner * vec2(cell);
    texel = in_letter.zw + corner * vec2(cell);
    vec2 device = pixel * whole_picture.zw * 2.0 - 1.0;
    gl_Position = part_clip(vec4(device.x, -device.y, 0.0, 1.0));
}
