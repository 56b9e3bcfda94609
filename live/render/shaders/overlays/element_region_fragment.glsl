// Lines that glow, regions with a soft border, streams along a line: by what is nearest of the line.
#include "frame.glsl"
#include "element_light.glsl"
#include "element_corners.glsl"

in vec2 place;
flat in int kind;
flat in float level;
flat in float radius;
flat in ivec2 range;
flat in int closed;
flat in vec2 home;
flat in float way;
out vec4 light;

struct Nearest {
    float away;     // distance from the line, or the point [m]
    bool inside;    // within a closed line
    float along;    // where on the line [m]
    float side;     // -1 or 1
};

Nearest nearest() {
    vec2 to = place - home;
    Nearest found = Nearest(dot(to, to), false, 0.0, 1.0);
    if (range.y > 0) {
        found.away = 1e12;
        float nearest = 0.0;   // number of the piece, and how much of it lies before
        vec4 a = corners[range.x];
        for (int i = 0; i < range.y; ++i) {
            vec4 b = corners[range.x + i + 1];
            vec2 piece = b.xy - a.xy, from = place - a.xy;
            float t = clamp(dot(from, piece) * a.w, 0.0, 1.0);
            vec2 off = from - piece * t;
            float away = dot(off, off);
            nearest = away < found.away ? float(i) + min(t, 0.9999) : nearest;
            found.away = min(found.away, away);
            if (closed == 1 && (a.y > place.y) != (b.y > place.y) && from.x < piece.x * from.y / piece.y) {
                found.inside = !found.inside;
            }
            a = b;
        }
        int i = range.x + int(nearest);
        vec2 piece = corners[i + 1].xy - corners[i].xy, from = place - corners[i].xy;
        found.along = mix(corners[i].z, corners[i + 1].z, fract(nearest));
        found.side = piece.x * from.y < piece.y * from.x ? -1.0 : 1.0;
    }
    found.away = sqrt(found.away);
    return found;
}

vec3 attracting(float d, bool line, float pulse) {
    if (line) {
        float core = hairline(d, 0.055) * 0.40, halo = bell(d, 0.40 + 0.05 * pulse) * (0.24 + 0.12 * pulse);
        return WARM * (core + halo);
    }
    float border = hairline(d, 0.06) * (0.22 + 0.14 * pulse);
    float within = d < 0.0 ? 0.075 + 0.13 * exp(d / 0.45) : 0.205 * bell(d, 0.28);
    return WARM * (border + within * (0.85 + 0.3 * pulse));
}

vec3 repelling(float d, bool line, float pulse) {
    float border = line ? 0.30 : 0.0;
    float ring = bell(d - border, 0.08) * 0.48;
    float outer = bell(d - border - 0.28 - 0.30 * (1.0 - pulse), 0.10) * 0.33 * pulse;
    float within = (1.0 - smoothstep(border - 0.3, border, d)) * 0.05;
    return COOL * (ring + outer + within);
}

vec3 streaming(Nearest here) {
    float start = corners[range.x].z, whole = corners[range.x + range.y].z - start, along = here.along - start;
    float trip = closed == 1 ? whole / max(round(whole / 2.4), 1.0) : 2.4;
    float lane = floor(here.away / 0.2 * here.side + 0.5);
    float light = stream(way * along, lane + 100.0, here.away * here.side - lane * 0.2, 0.045, trip);
    float width = max(radius, 0.25);
    float fade = 1.0 - smoothstep(width, width + 0.5, here.away);
    if (closed == 0) fade *= smoothstep(0.0, 0.4, along) * (1.0 - smoothstep(whole - 0.4, whole, along));
    return SILVER * (light * 0.62 + 0.025) * fade;
}

void main() {
    float pulse = square(1.0 - edge.w);
    bool line = radius <= 0.0 && closed == 0;
    Nearest here = nearest();
    float d = (closed == 1 && here.inside ? -here.away : here.away) - radius;
    vec3 colour;
    if (kind == ATTRACTOR) colour = attracting(d, line, pulse);
    else if (kind == REPULSOR) colour = repelling(d, line, pulse);
    else colour = streaming(here);
    light = vec4(colour * level * ELEMENT_LIGHT, 0.0);
}
