// A sheet of paper: loose washes of ink and water for ground and air, darker where the pigment dried at their borders.
#include "backdrop.glsl"

// One wash: how much pigment lies where `inside` is above 0 (soft, with a ragged border and a dried rim).
float wash(float inside, float ragged, float soft) {
    float d = inside + 0.55 * (ragged - 0.5);
    float body = smoothstep(0.0, soft, d);
    float rim = exp(-square((d - 0.03) / 0.028));
    return body * 0.75 + rim * 0.42;
}

void main() {
    vec3 direction = normalize(ray);
    vec2 screen = picture_place(at) * vec2(whole_picture.x * whole_picture.w, 1.0);
    float to_floor = floor_reach(direction);
    vec3 p = eye.xyz + direction * min(to_floor, 300.0);
    float ragged = clouds(screen * 0.55), fine = clouds(screen * 1.9 + 0.4);
    float edges = 0.68 * ragged + 0.32 * fine;
    // the ground: two washes around the stage, nearer one stronger
    float seen = smoothstep(-0.02, -0.07, direction.y);
    vec2 off = p.xz / (stage.xy + vec2(2.4, 1.6));
    float ground = wash(0.75 - length(off), edges, 0.55) * seen;
    vec2 inner = (p.xz - vec2(0.25, -0.2)) / (stage.xy + vec2(0.2, 0.0));
    float second = wash(0.70 - length(inner), 1.0 - fine, 0.45) * seen;
    // the air: one broad stroke behind the dancers, dry at its ends
    float height = direction.y / max(length(direction.xz), 1e-3);
    float stroke = 0.20 - abs(height - 0.19 - 0.03 * sin(direction.x * 5.0)) - 0.16 * square(direction.x * 1.3);
    float bristles = textureLod(noise_map, vec2(screen.x * 0.05, screen.y * 2.6), 0.0).g;
    float air = wash(stroke * 2.2, mix(edges, bristles, 0.45), 0.40) * (0.45 + 0.55 * ragged);

    vec3 sheet = light_background();
    vec3 cool = vec3(0.50, 0.62, 0.74), warm = vec3(0.80, 0.66, 0.48);
    vec3 colour = sheet * mix(vec3(1.0), warm, 0.75 * ground);
    colour *= mix(vec3(1.0), vec3(0.60, 0.57, 0.62), 0.45 * second);
    colour *= mix(vec3(1.0), cool, 0.62 * air);
    keep(colour * (key_light.rgb * 0.5 + fill_above.rgb * 0.25), 0.85 * smoothstep(-0.01, -0.05, direction.y));
}
