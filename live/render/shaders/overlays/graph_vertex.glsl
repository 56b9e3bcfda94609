// Instance 0 is the panel, 1 and 2 are lines at one and two periods, the others are frames.
#include "frame.glsl"
uniform vec4 panel;      // x, y, width, height [pixels], from the lower left corner
uniform float period;    // [ms]

in float in_time;        // [ms]; the first three mean nothing

out vec4 colour;

void main() {
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    vec4 box;
    if (gl_InstanceID == 0) {
        box = panel;
        colour = vec4(0.02, 0.02, 0.03, 0.62);
    } else if (gl_InstanceID < 3) {
        float high = float(gl_InstanceID) / 3.0;
        box = vec4(panel.x, panel.y + panel.w * high, panel.z, 1.0);
        colour = vec4(1.0, 1.0, 1.0, 0.35);
    } else {
        float wide = panel.z / float(FRAMES);
        float high = clamp(in_time / (3.0 * period), 0.0, 1.0);
        box = vec4(panel.x + wide * float(gl_InstanceID - 3), panel.y, wide, panel.w * high);
        float late = in_time / period;
        colour = late > 1.5 ? vec4(1.0, 0.27, 0.18, 0.95) : (late > 1.15 ? vec4(1.0, 0.72, 0.20, 0.85) : vec4(0.45, 0.85, 0.62, 0.70));
    }
    vec2 pixel = box.xy + corner * box.zw;
    gl_Position = part_clip(vec4(pixel * whole_picture.zw * 2.0 - 1.0, 0.0, 1.0));
}
