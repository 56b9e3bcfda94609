// The black box: floor, back wall and light in the haze.
#include "backdrop.glsl"

const int LAMPS = 6;

float lamp_side(int k) { return (float(k) - 0.5 * float(LAMPS - 1)) / (0.5 * float(LAMPS - 1)); }
vec3 lamp_tint(int k) { return (k & 1) == 0 ? rim_light.rgb : mix(rim_light.rgb, key_light.rgb, 0.45); }

// Light scattered by the haze along the ray: cones from lamps above the back of the stage. Across a cone the light
// falls off like a Gaussian, so its integral along the ray is known from where the two lines are nearest.
vec3 beams(vec3 start, vec3 direction, float reach) {
    vec3 sum = vec3(0.0);
    for (int k = 0; k < LAMPS; ++k) {
        vec3 lamp = vec3(lamp_side(k) * stage.x * 1.10, 7.5, -stage.y - 1.2);
        vec3 aim = normalize(vec3(lamp_side(k) * stage.x * 0.45, 0.0, -0.1 * stage.y) - lamp);
        float together = dot(direction, aim);
        float across = max(1.0 - together * together, 0.02);
        vec3 gap = start - lamp;
        float along = max((dot(gap, aim) - together * dot(gap, direction)) / across, 0.0);
        float away = (together * dot(gap, aim) - dot(gap, direction)) / across;
        float off = distance(start + direction * away, lamp + aim * along);
        float width = 0.05 + 0.115 * along;
        float cone = exp(-2.0 * off * off / (width * width)) / (0.5 + 0.10 * along * along);
        float reached = smoothstep(-width, width, reach - away) * smoothstep(0.0, 0.3, along);
        sum += lamp_tint(k) * (cone * reached * width * 1.2533 / sqrt(across));
    }
    return sum * 0.028;
}

vec3 floor_light(vec2 place, vec3 direction) {
    vec2 at_stage = place / (stage.xy + vec2(0.3, 0.5));
    float reach = dot(at_stage, at_stage);
    float wash = 1.0 / (1.0 + 1.6 * reach * reach);
    vec3 light = key_light.rgb * wash * 1.2;
    // pools of cool light from the lamps behind
    vec3 pools = vec3(0.0);
    for (int k = 0; k < LAMPS; ++k) {
        vec2 off = (place - vec2(lamp_side(k) * stage.x * 0.45 * 1.05, -0.1 * stage.y)) / vec2(1.3, 1.9);
        pools += lamp_tint(k) * exp(-dot(off, off));
    }
    light += pools * 0.42;
    float back = exp(-square((place.y + stage.y) / (stage.y * 0.9))) * exp(-square(place.x / (stage.x * 1.3)));
    light += rim_light.rgb * back * 0.35;
    light += background_bottom() * (background_gradient() * 2.2 * exp(-(place.y + stage.y + WALL_BEHIND) * 0.42));
    float seam = 1.0 - 0.12 * exp(-square((fract(place.x / 1.5 + 0.5) - 0.5) * 1.5 / 0.014));
    vec3 colour = own_floor(0.12) * light * seam;
    // a dull sheen: the lamps behind are mirrored at low angles
    float low = pow(1.0 - clamp(-direction.y, 0.0, 1.0), 6.0);
    return colour + rim_light.rgb * low * back * 0.16;
}

vec3 wall_light(vec3 p) {
    float up = max(p.y, 0.0);
    float side = exp(-square(p.x / (stage.x * 1.15)));
    vec3 low = rim_light.rgb * 0.070 * exp(-up * 0.75);
    vec3 high = mix(rim_light.rgb, key_light.rgb, 0.35) * 0.010 * exp(-square((up - 2.6) / 2.4));
    vec3 plain = own_background(0.06) * 0.55 + (low + high) * (0.12 + 0.88 * side);
    float at = smoothstep(-0.3, 7.0, up);
    vec3 cyclorama = mix(background_bottom(), background_top(), at) * (0.55 + 0.45 * side) + (low + high) * side;
    return mix(plain, cyclorama, background_gradient());
}

void main() {
    vec3 direction = normalize(ray);
    float wall_z = -stage.y - WALL_BEHIND;
    float to_wall = direction.z < -1e-4 ? (wall_z - eye.z) / direction.z : 1e4;
    float to_floor = direction.y < -1e-4 ? -eye.y / direction.y : 1e4;
    float reach = min(min(to_wall, to_floor), 60.0);
    vec3 p = eye.xyz + direction * reach;
    vec3 colour;
    float shade = 0.0;
    if (to_floor < to_wall) {
        float far = smoothstep(wall_z + 2.4, wall_z, p.z);
        colour = mix(floor_light(p.xz, direction), wall_light(vec3(p.x, 0.0, p.z)), far);
        shade = (1.0 - far) * (1.0 - haze_at(p));
    } else {
        colour = wall_light(p);
    }
    colour = mix(colour, haze_light(p.y), haze_at(p) * (to_floor < to_wall ? 1.0 : 0.6));
    colour += beams(eye.xyz, direction, reach);
    keep(colour, shade);
}
