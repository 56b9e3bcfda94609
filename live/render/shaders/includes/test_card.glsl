// Test cards: drawn by formula, so that lines are as sharp as the projector at any size.
#define GRID 1
#define BARS 2
#define NAME 3
#define SAFE 4
#define FOCUS 5
#define JOIN 6

uniform vec2 window_size;    // pixels of the window
uniform vec2 frame_size;     // pixels of the frame, upright: the window's, turned with the picture
uniform vec2 picture_size;   // pixels of the whole picture
uniform vec3 card_tint;      // this output's own colour
uniform sampler2D words;     // its name, and what it is
uniform vec2 words_size;     // pixels of that
uniform sampler2D sheet;     // what an audience joins by
uniform vec2 sheet_size;     // pixels of that

uniform int tick;            // the one that a render node presents; negative: it is no node
uniform sampler2D digits;    // 0 to 9 beside each other

const int DIGITS = 7;        // 1.8 days of ticks
const float SWEEP = 256.0;   // ticks in which the line crosses the picture

const vec3 GREY = vec3(0.5);

float line(float distance, float breadth) { return 1.0 - smoothstep(breadth - 0.5, breadth + 0.5, abs(distance)); }

float repeated(float x, float period, float breadth) {
    return line(mod(x + 0.5 * period, period) - 0.5 * period, breadth);
}

// A rectangle's outline, `inset` pixels within one of `size`.
float outline(vec2 pixel, vec2 size, vec2 inset, float breadth) {
    vec2 inside = min(pixel, size - pixel) - inset;
    return line(min(inside.x, inside.y), breadth);
}

float ring(vec2 pixel, vec2 middle, float radius, float breadth) {
    return line(length(pixel - middle) - radius, breadth);
}

// The words, as tall as asked, around a point.
float written(vec2 pixel, vec2 middle, float height) {
    vec2 size = words_size * height / words_size.y;
    float fit = min(1.0, 0.9 * frame_size.x / size.x);
    vec2 at = (pixel - middle) / (size * fit) + 0.5;
    return any(lessThan(at, vec2(0.0))) || any(greaterThan(at, vec2(1.0))) ? 0.0 : texture(words, at).r;
}

// The grid belongs to the picture: where projectors overlap their lines must meet. Circles must be round.
vec3 grid_card(vec2 pixel, vec2 part) {
    vec2 of = part * picture_size, middle = 0.5 * picture_size;
    float cell = picture_size.y / 10.0, fine = max(picture_size.y / 1080.0, 1.0);
    float lines = max(repeated(of.x - middle.x, cell, fine), repeated(of.y - middle.y, cell, fine));
    float strong = max(line(of.x - middle.x, 1.5 * fine), line(of.y - middle.y, 1.5 * fine));
    strong = max(strong, ring(of, middle, 4.0 * cell, 1.5 * fine));
    vec2 corner = vec2(1.5 * cell);
    vec2 nearest = min(of, picture_size - of);
    strong = max(strong, ring(nearest, corner, cell, fine));
    vec2 slope = normalize(picture_size);
    lines = max(lines, 0.8 * line(dot(nearest, vec2(slope.y, -slope.x)), fine));
    float border = outline(pixel, frame_size, vec2(1.0), 1.5);
    vec3 colour = vec3(0.02) + card_tint * (0.55 * lines + strong);
    colour = mix(colour, vec3(1.0, 0.12, 0.08), border);
    float name = written(pixel, 0.5 * frame_size + vec2(0.0, 0.13 * frame_size.y), 0.11 * frame_size.y);
    return mix(min(colour, 1.0), vec3(1.0), name);
}

// Bars at three quarters, the same in full light turned about, a ramp, and steps near black and white.
vec3 bars_card(vec2 at) {
    float bar = min(floor(at.x * 7.0), 6.0);
    float code = 7.0 - bar;  // white, yellow, cyan, green, magenta, red, blue: green weighs most
    vec3 colour = vec3(mod(floor(code / 2.0), 2.0), floor(code / 4.0), mod(code, 2.0));
    if (at.y < 0.62) return 0.75 * colour;
    if (at.y < 0.70) {
        code = bar + 1.0;
        return vec3(mod(floor(code / 2.0), 2.0), floor(code / 4.0), mod(code, 2.0));
    }
    if (at.y < 0.82) return vec3(at.x);
    if (at.y < 0.90) return vec3(floor(at.x * 11.0) / 10.0);
    float part = floor(at.x * 10.0);
    return part < 5.0 ? vec3(part * 0.02) : vec3(1.0 - (9.0 - part) * 0.02);
}

vec3 name_card(vec2 pixel) {
    vec2 middle = 0.5 * frame_size;
    float unit = frame_size.y;
    vec3 colour = 0.16 * card_tint;
    colour = mix(colour, card_tint, outline(pixel, frame_size, vec2(0.02 * unit), 0.008 * unit));
    vec2 up = pixel - vec2(middle.x, 0.16 * unit);  // an arrow: this side is up
    float arrow = up.y > -0.06 * unit && up.y < 0.02 * unit && abs(up.x) < 0.9 * (up.y + 0.06 * unit) ? 1.0 : 0.0;
    arrow = max(arrow, abs(up.x) < 0.02 * unit && up.y >= 0.02 * unit && up.y < 0.09 * unit ? 1.0 : 0.0);
    colour = mix(colour, card_tint, arrow);
    return mix(colour, vec3(1.0), written(pixel, middle + vec2(0.0, 0.08 * unit), 0.34 * unit));
}

// What is surely seen: nine tenths for what happens, eight for what is read; the middle, and thirds.
vec3 safe_card(vec2 pixel) {
    float fine = max(frame_size.y / 900.0, 0.8);
    vec2 middle = 0.5 * frame_size, third = frame_size / 3.0;
    vec2 share = min(pixel, frame_size - pixel) / frame_size;
    float inside = min(share.x, share.y);
    vec3 colour = inside < 0.05 ? vec3(0.17, 0.03, 0.03) : inside < 0.1 ? vec3(0.13, 0.11, 0.02) : vec3(0.05);
    float thirds = max(repeated(pixel.x, third.x, 0.6 * fine), repeated(pixel.y, third.y, 0.6 * fine));
    colour = mix(colour, GREY, 0.35 * thirds);
    colour = mix(colour, vec3(1.0, 0.35, 0.2), outline(pixel, frame_size, 0.05 * frame_size, fine));
    colour = mix(colour, vec3(1.0, 0.85, 0.25), outline(pixel, frame_size, 0.10 * frame_size, fine));
    colour = mix(colour, vec3(1.0), outline(pixel, frame_size, vec2(0.5), 1.0));
    vec2 off = abs(pixel - middle);
    float reach = 0.06 * frame_size.y;
    float lines = max(off.x < reach ? line(off.y, fine) : 0.0, off.y < reach ? line(off.x, fine) : 0.0);
    colour = mix(colour, vec3(1.0), max(lines, ring(pixel, middle, 0.5 * reach, fine)));
    return mix(colour, vec3(0.9), written(pixel, vec2(middle.x, 0.81 * frame_size.y), 0.09 * frame_size.y));
}

// A star of 36 rays: where it turns grey the lens does not resolve any more.
float star(vec2 off, float radius) {
    float far = length(off);
    if (far > radius) return -1.0;
    float width = far * 6.2831853 / 72.0;  // of one ray [pixels]
    float rays = sin(36.0 * atan(off.y, off.x)) * width * 1.6;
    return far < 2.0 ? 0.5 : clamp(rays + 0.5, 0.0, 1.0);
}

vec3 focus_card(vec2 pixel) {
    vec2 middle = 0.5 * frame_size, of = abs(pixel - middle);
    float radius = 0.22 * frame_size.y, small = 0.13 * frame_size.y;
    float seen = star(pixel - middle, radius);
    if (seen < 0.0) seen = star(of - (middle - 1.25 * small), small);
    if (seen >= 0.0) return vec3(seen);
    vec2 whole = floor(pixel);
    vec2 block = abs(of - vec2(0.5 * frame_size.x - 2.8 * small - 0.25 * small, 0.0));
    float near = 0.5 * small;
    if (block.x < near && of.y < 2.0 * near)  // single pixels, then pairs: upright, level, chequered
        return vec3(of.y < 0.66 * near ? mod(whole.x + whole.y, 2.0)
                    : of.y < 1.33 * near ? mod(pixel.y < middle.y ? whole.x : whole.y, 2.0)
                    : mod(floor(0.5 * (pixel.y < middle.y ? whole.x : whole.y)), 2.0));
    float border = outline(pixel, frame_size, vec2(0.5), 1.0);
    float name = written(pixel, vec2(middle.x, 0.83 * frame_size.y), 0.09 * frame_size.y);
    return mix(vec3(0.12), vec3(1.0), max(border, name));
}

// The code to join by, upright in the middle, over the dance in little light: nobody misses what happens.
vec3 join_card(vec2 pixel, vec3 dance) {
    float scale = 0.9 * min(frame_size.y / sheet_size.y, frame_size.x / sheet_size.x);
    vec2 at = (pixel - 0.5 * frame_size) / (sheet_size * scale) + 0.5;
    bool outside = any(lessThan(at, vec2(0.0))) || any(greaterThan(at, vec2(1.0)));
    return outside ? 0.35 * dance : vec3(texture(sheet, at).r * 0.92);
}

// The number of the tick, as tall as asked, around a point.
float counted(vec2 pixel, vec2 middle, float height) {
    vec2 one = vec2(0.6 * height, height);
    vec2 at = (pixel - middle) / one + vec2(0.5 * float(DIGITS), 0.5);
    if (at.x < 0.0 || at.x >= float(DIGITS) || at.y < 0.0 || at.y >= 1.0) return 0.0;
    int place = DIGITS - 1 - int(at.x), left = tick;
    for (int i = 0; i < DIGITS; ++i) if (i < place) left /= 10;
    return texture(digits, vec2((float(left % 10) + fract(at.x)) / 10.0, at.y)).r;
}

// Over the card of a render node: a slanting line through the whole picture, which must meet across the seams and moves
// with the ticks, so that it breaks where a node is late; and the number of the tick.
vec3 with_tick(vec3 colour, vec2 pixel, vec2 part) {
    float across = mod(float(tick), SWEEP) / SWEEP;
    float off = mod(part.x + 0.25 * (part.y - 0.5) - across + 0.5, 1.0) - 0.5;
    float sweep = line(off * picture_size.x, max(picture_size.y / 360.0, 1.5));
    vec2 middle = vec2(0.5 * frame_size.x, 0.94 * frame_size.y);
    float height = 0.06 * frame_size.y;
    vec2 inside = abs(pixel - middle) / (vec2(0.3 * float(DIGITS) + 0.2, 0.55) * height);
    if (max(inside.x, inside.y) < 1.0) return vec3(counted(pixel, middle, height));
    return mix(colour, vec3(1.0, 0.9, 0.2), sweep);
}

vec3 card_colour(int card, vec2 at, vec2 part) {
    vec2 pixel = at * frame_size;
    vec3 colour = card == GRID ? grid_card(pixel, part) : card == BARS ? bars_card(at) : card == NAME ? name_card(pixel)
                : card == SAFE ? safe_card(pixel) : focus_card(pixel);
    return tick < 0 ? colour : with_tick(colour, pixel, part);
}
