// Marks over a window: a panel, letters on it, points that can be moved. Pixels, y down.
uniform vec2 window_size;

in vec4 in_box;       // x, y, width, height
in vec4 in_what;      // texel of a letter; what it is: 0 panel, 1 letter, 2 point; whether it is the chosen one

out vec2 across;      // -1 to 1 in the box
out vec2 texel;
out float pixels;     // half the box's width
flat out vec2 what;

void main() {
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    across = corner * 2.0 - 1.0;
    pixels = 0.5 * in_box.z;
    texel = in_what.xy + corner * in_box.zw;
    what = in_what.zw;
    vec2 device = (in_box.xy + corner * in_box.zw) / window_size * 2.0 - 1.0;
    gl_Position = vec4(device.x, -device.y, 0.0, 1.0);
}
