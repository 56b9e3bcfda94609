// Light on the floor around a point: attractor, repulsor, spreader, an audience's voice, flows out of or around it.
#include "frame.glsl"
#include "element_light.glsl"

in vec2 offset;
flat in int kind;
flat in float level;
flat in float radius;
flat in float flow;
flat in vec3 ember;
out vec4 light;

vec3 attractor(float away, float pulse) {
    float pool = bell(away, 0.62 + 0.08 * pulse);
    float ring = bell(away - 0.95 - 0.10 * pulse, 0.07) * 0.28;
    return WARM * (pool * (0.42 + 0.16 * pulse) + ring * (0.4 + 0.6 * pulse));
}

vec3 repulsor(float away, float pulse) {
    float ring = bell(away - 0.85, 0.085);
    float outer = bell(away - 1.15 - 0.30 * (1.0 - pulse), 0.10) * 0.35 * pulse;
    float within = (1.0 - smoothstep(0.55, 0.85, away)) * 0.05;
    return COOL * (ring * 0.55 + outer + within);
}

vec3 spreader(float away, float pulse) {
    vec2 cell = abs(fract(offset / 0.8) - 0.5) * 0.8;
    float line = max(bell(0.4 - cell.x, 0.022), bell(0.4 - cell.y, 0.022));
    float halo = bell(away - 2.2 - 0.4 * (1.0 - pulse), 0.22) * 0.35;
    float fade = 1.0 - smoothstep(1.0, 2.7, away);
    return MINT * (line * fade * 0.16 + fade * 0.035 + halo * 0.5);
}

vec3 voice(float away) { return ember * (hairline(away, 0.06) * 0.75 + bell(away, 0.24) * 0.16); }

// A phone's light: a pool in its colour; one that sends away is a ring.
vec3 phone(float away, float pulse) {
    float rim = hairline(away - 0.34 - 0.10 * pulse, 0.045);
    if (flow > 0.5) return ember * (rim * 1.3 + hairline(away - 0.56 - 0.14 * pulse, 0.03) * 0.7);
    return ember * (bell(away, 0.24) * 1.1 + rim * 0.9);
}

vec3 current(float away) {
    bool vortex = int(abs(flow) + 0.5) - 1 == VORTEX;
    float way = sign(flow), angle = atan(offset.y, offset.x) / 6.2831853;
    float light;
    if (vortex) {
        float lane = floor(away / 0.22);
        float middle = (lane + 0.5) * 0.22;
        float trips = max(round(6.2831853 * middle / 2.4), 1.0);
        light = stream(way * angle * trips, lane + 1.0, away - middle, 0.045, 1.0);
    } else {
        float lane = floor((angle + 0.5) * 40.0);
        float middle = (lane + 0.5) / 40.0 - 0.5;
        light = stream(way * away, lane + 1.0, (angle - middle) * 6.2831853 * away, 0.045, 1.8);
    }
    // it acts everywhere, but is drawn where its middle can be seen in it
    float fade = radius > 0.0 ? 1.0 - smoothstep(radius - 0.3, radius + 0.5, away) : 1.0 - smoothstep(1.4, 3.3, away);
    return SILVER * (light * 0.62 * smoothstep(0.15, 0.6, away) + 0.02) * fade;
}

void main() {
    float away = length(offset);
    float pulse = square(1.0 - edge.w);
    vec3 colour;
    if (kind == ATTRACTOR) colour = attractor(away, pulse);
    else if (kind == REPULSOR) colour = repulsor(away, pulse);
    else if (kind == SPREADER) colour = spreader(away, pulse);
    else if (kind == VOICE) colour = voice(away);
    else if (kind == PHONE) colour = phone(away, pulse);
    else colour = current(away);
    light = vec4(colour * level * ELEMENT_LIGHT, 0.0);
}
