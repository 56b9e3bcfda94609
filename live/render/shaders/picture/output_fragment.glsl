// What a projector throws: its part of the picture or a test card, its soft edges, mask, brightness and gamma.
// TINTED, GAMMA, BLACK, MASKED, CARD: what is left out costs nothing (llvmpipe works off both sides of every branch).
#include "test_card.glsl"
in vec2 frame;

uniform sampler2D picture;
uniform sampler2D mask;
uniform vec4 crop;         // x, y, width, height in the picture, y down
uniform vec4 drawn;        // the same of what is drawn of the picture
uniform mat3x2 turned;     // from the frame to the upright part of the picture: rotation and mirror
uniform vec4 edge;         // breadth of the soft edges: left, right, top, bottom
uniform vec3 blend;        // projector's gamma, its black, how many projectors overlap at most
uniform vec3 light;        // brightness, gamma, by what the flash limit multiplies signals
uniform bool bent;         // whether the frame's border must be smoothed
uniform int card;          // which one

out vec4 shown;

// How much of the light is this projector's, so far into an edge: with the other one's it is all of it.
float share(float inside, float breadth) {
    float t = breadth > 0.0 ? clamp(inside / breadth, 0.0, 1.0) : 1.0;
    return t * t * (3.0 - 2.0 * t);
}

vec3 tint(vec3 colour, vec2 at) {
    vec4 inside = vec4(at.x, 1.0 - at.x, at.y, 1.0 - at.y);
    float mine = share(inside.x, edge.x) * share(inside.y, edge.y) * share(inside.z, edge.z) * share(inside.w, edge.w);
    float left = mine * light.x;
    vec3 toned = colour;   // powers are dear
#if GAMMA
    toned = pow(colour, vec3(light.y));
#endif
#if !BLACK
    return left < 1.0 ? toned * pow(left, 1.0 / blend.x) : toned;
#else
    bvec4 under = lessThan(inside, edge);
    float others = (under.x || under.y ? 2.0 : 1.0) * (under.z || under.w ? 2.0 : 1.0);
    float lift = blend.y * (blend.z / others - 1.0);  // black is that much brighter where all overlap
    return pow(lift + (1.0 - lift) * pow(toned, vec3(blend.x)) * left, vec3(1.0 / blend.x));
#endif
}

// The picture at a place of the whole one, y down.
vec3 picture_at(vec2 place) {
    vec2 here = (place - drawn.xy) / drawn.zw;
    return texture(picture, vec2(here.x, 1.0 - here.y)).rgb;
}

void main() {
    vec2 at = turned * vec3(frame, 1.0);
    vec2 part = crop.xy + at * crop.zw;
#if CARD
    vec3 colour = card == JOIN ? join_card(at * frame_size, picture_at(part))
                               : card_colour(card, at, part);
#else
    vec3 colour = picture_at(part);
#endif
#if TINTED
    if (CARD == 0 || card == BARS || card == JOIN) colour = tint(colour, at);
#if MASKED
    vec2 window = gl_FragCoord.xy / window_size;
    float open = texture(mask, vec2(window.x, 1.0 - window.y)).r;
    if (open < 1.0) colour *= pow(open, 1.0 / blend.x);
#endif
#endif
    colour *= light.z;
    if (bent) {
        vec2 step = max(fwidth(frame), vec2(1e-9));
        vec2 inside = min(frame, 1.0 - frame) / step + 0.5;
        colour *= clamp(inside.x, 0.0, 1.0) * clamp(inside.y, 0.0, 1.0);
    }
    shown = vec4(colour, 1.0);
}
