// An open field at dusk: the sun has just reached the hills behind the stage.
#include "backdrop.glsl"

const vec3 SUN = vec3(0.24, 0.052, -0.969);

float hill(float angle, float size, float seed) {
    return size * (0.35 + textureLod(noise_map, vec2(angle * 0.21 + seed, seed), 0.0).r
                   + 0.22 * textureLod(noise_map, vec2(angle * 0.83 + seed, 0.7 - seed), 0.0).g);
}

vec3 sky(vec3 d) {
    float up = clamp(d.y, 0.0, 1.0);
    float towards = max(dot(d, SUN), 0.0), warm = towards * towards;
    vec3 low = background_bottom() * (0.22 + 0.62 * warm * warm);
    vec3 middle = mix(vec3(0.30, 0.26, 0.42), vec3(0.80, 0.36, 0.26), warm) * 0.42;
    vec3 colour = mix(low, middle, smoothstep(0.0, 0.17, up));
    colour = mix(colour, background_top() * 2.6, smoothstep(0.04, 0.42, up));
    // clouds: a thin layer high up, lit from below where the sun is near
    vec2 c = d.xz / (up + 0.10) * vec2(0.05, 0.13);
    float cover = clouds(c + vec2(0.13, 0.4));
    float cloud = smoothstep(0.50, 0.88, cover) * smoothstep(0.015, 0.12, up);
    float thick = smoothstep(0.62, 0.98, cover);
    vec3 edge = mix(vec3(0.55, 0.34, 0.40), vec3(1.5, 0.62, 0.26), warm) * (0.55 + 0.75 * warm);
    vec3 core = mix(vec3(0.12, 0.12, 0.20), vec3(0.52, 0.22, 0.20), warm);
    colour = mix(colour, mix(edge, core, thick), cloud * 0.85);
    float sharp = towards * towards; sharp *= sharp; sharp *= sharp; sharp *= sharp;   // to the 16th
    colour += vec3(1.0, 0.50, 0.18) * (0.34 * sharp * warm);
    float disc = sharp * sharp; disc *= disc; disc *= disc; disc *= disc;              // to the 256th
    return colour + vec3(1.6, 0.85, 0.36) * disc * disc * 0.8;
}

void main() {
    vec3 d = normalize(ray);
    float angle = atan(d.x, -d.z), height = d.y / max(length(d.xz), 1e-3);
    vec3 colour = sky(d);
    float near_sun = exp(-square((angle - 0.243) / 0.55));
    vec3 air = background_bottom() * (0.30 + 0.45 * near_sun) + vec3(0.05, 0.06, 0.12);
    float far_hills = hill(angle, 0.072, 0.12), hills = hill(angle, 0.042, 0.56), trees = hill(angle * 3.0, 0.016, 0.83);
    float soft = fwidth(height) + 5e-4;
    colour = mix(colour, mix(vec3(0.10, 0.10, 0.20), air, 0.62), smoothstep(soft, -soft, height - far_hills));
    colour = mix(colour, mix(vec3(0.045, 0.05, 0.085), air, 0.30), smoothstep(soft, -soft, height - hills));
    trees += 0.004 * textureLod(noise_map, vec2(angle * 2.7, 0.2), 0.0).g;
    colour = mix(colour, mix(vec3(0.018, 0.020, 0.026), air, 0.10), smoothstep(soft, -soft, height - trees));
    float shade = 0.0;
    float to_floor = floor_reach(d);
    if (to_floor < 900.0) {
        vec3 p = eye.xyz + d * to_floor;
        float patches = clouds(p.xz * 0.035), tufts = textureLod(noise_map, p.xz * 0.21, min(to_floor * 0.12, 7.0)).g;
        vec2 off = p.xz / (stage.xy + 2.2);
        float trodden = exp(-square(dot(off, off)) * 1.3);   // where they dance the grass is short and dry
        vec3 grass = mix(own_floor(0.08) * vec3(0.50, 0.72, 0.62), own_floor(0.08) * vec3(1.15, 1.0, 0.85), 0.30 * patches + 0.50 * trodden);
        grass *= 0.72 + 0.56 * tufts;
        float low_sun = max(key_direction.y, 0.0);
        vec3 light = key_light.rgb * (low_sun * 2.1) + fill_above.rgb * 1.3;
        vec3 ground = grass * light;
        // light that comes through the blades, towards the sun
        vec2 way = normalize(d.xz);
        float through = pow(max(dot(way, normalize(SUN.xz)), 0.0), 6.0) * pow(1.0 - clamp(-d.y, 0.0, 1.0), 5.0);
        ground += key_light.rgb * grass * through * (1.4 + 1.2 * tufts);
        float far = 1.0 - exp(-to_floor * 0.016);
        colour = mix(ground, mix(vec3(0.03, 0.032, 0.04), air, 0.55) , far * 0.85);
        shade = smoothstep(70.0, 18.0, to_floor) * 0.92;
    }
    keep(colour, shade);
}
