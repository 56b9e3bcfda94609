// A set piece from a file, with images as a character has them.
#include "frame.glsl"
in vec3 in_position;
in vec3 in_normal;
in float in_openness;
in vec2 in_uv;
in vec4 in_tint;
in vec4 in_finish;

out vec3 place;
out vec4 facing;          // normal, openness
out vec4 worn_at;
out vec4 worn_tint;
flat out int worn_extra;

void main() {
    place = in_position;
    facing = vec4(in_normal, in_openness);
    worn_at = vec4(in_uv, in_finish.x * 255.0, in_finish.y / max(in_finish.z, 0.004));
    worn_tint = in_tint;
    worn_extra = int(in_finish.w * 255.0 + 0.5);
    gl_Position = world_to_clip * vec4(in_position, 1.0);
}
