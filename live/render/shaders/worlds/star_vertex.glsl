// A star: a point far away that twinkles a little with the beat, each in its own turn.
#include "frame.glsl"
in vec3 in_place;
in vec3 in_chance;

out vec3 light;

void main() {
    gl_Position = world_to_clip * vec4(in_place, 1.0);
    float scale = ray_corner.w / gl_Position.w;
    float big = in_chance.x * in_chance.x; big *= big; big *= big;
    float size = scale * mix(0.018, 0.085, big), shown_ = max(size, 1.25 * whole_picture.y / 720.0);
    float turn = 6.28318531 * (beam_light.w / 8.0 + in_chance.y);
    float twinkle = 0.78 + 0.22 * sin(turn) + 0.25 * big * key_direction.w;
    vec3 tint = mix(mix(vec3(0.62, 0.74, 1.0), vec3(1.0), in_chance.z * 2.0), vec3(1.0, 0.80, 0.58), max(in_chance.z * 2.0 - 1.0, 0.0));
    float far = smoothstep(60.0, 12.0, gl_Position.w);
    light = tint * (share_constellation() * twinkle * (0.34 + 1.5 * big) * min(size / shown_ + 0.35, 1.0) * (0.35 + 0.65 * far));
    gl_PointSize = shown_ * 2.2;
}
