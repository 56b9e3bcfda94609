// Light that the haze scatters to the eye from cones of light: along each ray their integral is known from where ray and
// axis are nearest, for across a cone the light falls off like a Gaussian (as in backdrop_fragment.glsl).
#include "frame.glsl"
#include "beams.glsl"
#include "noise.glsl"

in vec2 at;
in vec3 ray;
out vec4 shown;

// Smoke that drifts: soft noise in two planes that move through each other, the same after 64 beats.
float smoke(vec3 p, float beat) {
    float t = beat / 64.0;
    float a = textureLod(noise_map, vec2(p.x + 0.5 * p.z, p.y) * 0.085 + vec2(1.0, -1.0) * t, 0.0).r;
    float b = textureLod(noise_map, vec2(p.z - 0.4 * p.x, p.y * 1.2) * 0.15 + vec2(-1.0, -2.0) * t, 0.0).g;
    return 0.30 + 1.4 * a * b + 0.35 * a;
}

// The smoke on a ray, at two depths: beams lie between or near them.
struct Smoke { float near; float far; float a; float b; };

Smoke smoke_on(vec3 start, vec3 direction) {
    float back = max(-direction.z, 0.05);
    float a = clamp((start.z - 0.4 * stage.y) / back, 0.0, 40.0), b = clamp((start.z + 0.9 * stage.y) / back, a + 0.5, 60.0);
    return Smoke(smoke(start + direction * a, beam_light.w), smoke(start + direction * b, beam_light.w), a, b);
}

float smoke_at(Smoke known, float away) { return mix(known.near, known.far, clamp((away - known.a) / (known.b - known.a), 0.0, 1.0)); }

float cone(vec3 lamp, vec3 aim, float begin, float spread, vec3 start, vec3 direction, float reach, Smoke known) {
    float together = dot(direction, aim);
    float across = max(1.0 - together * together, 0.02);
    vec3 gap = start - lamp;
    float along = max((dot(gap, aim) - together * dot(gap, direction)) / across, 0.0);
    float away = (together * dot(gap, aim) - dot(gap, direction)) / across;
    vec3 nearest = start + direction * away;
    float off = distance(nearest, lamp + aim * along);
    float width = begin + spread * along;
    float light = exp(-2.0 * off * off / (width * width)) / (0.35 + 6.0 * spread * spread * along * along + 0.05 * along);
    float deep = width / sqrt(across);   // about half of the ray's way through the cone: an eye within sees what is ahead
    float seen = smoothstep(-width, width, reach - away) * smoothstep(0.0, 0.25, along) * smoothstep(-deep, deep, away);
    return light * seen * width * 1.2533 / sqrt(across) * smoke_at(known, away);
}

void main() {
    vec3 direction = normalize(ray), start = eye.xyz;
    float wall_z = -stage.y - 3.0;
    float to_wall = direction.z < -1e-4 ? (wall_z - start.z) / direction.z : 1e4;
    float to_floor = direction.y < -1e-4 ? -start.y / direction.y : 1e4;
    float reach = min(min(to_wall, to_floor), 60.0);
    vec3 sum = vec3(0.0);
    Smoke known = smoke_on(start, direction);
    if (light_beams() > 0.0) {
        for (int k = 0; k < LAMPS; ++k) {
            vec3 lamp = beam_lamp(k), foot = vec3(beam_foot(k), 0.0).xzy;
            sum += beam_tint(k) * cone(lamp, normalize(foot - lamp), 0.06, light_beams_width(), start, direction, reach, known);
        }
        sum *= beam_answer();
    }
    for (int k = spots_begin(); k < spots_end(); ++k) {
        vec3 lamp = spot_lamp(k), to = vec3(spot_place[k].x, 0.7, spot_place[k].y) - lamp;
        float far = length(to);
        float spread = spot_place[k].z / far * 0.8;
        sum += spot_light[k].rgb * 0.30 * cone(lamp, to / far, 0.06, spread, start, direction, reach, known);
    }
    shown = vec4(sum * 0.13 * key_light.w, 1.0);
}
