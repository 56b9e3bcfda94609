// Letters of a title, over the picture or standing in the stage.
#include "frame.glsl"
in vec2 in_corner;       // [ems]
in vec2 in_texel;
in vec2 in_order;        // of the letter, 0 to 1; place in the line, 0 to 1

uniform int standing;    // 1: in the stage
uniform vec3 origin;     // middle: in clip space, or [m]
uniform vec2 em;         // an em: in clip space, or [m]
uniform int entrance;    // 0 cut, 1 fade, 2 rise, 3 wipe, 4 type
uniform float progress;
uniform float texture_size;
uniform int mirrored;

out vec2 texel;
out float across;
out float shows;
out vec3 place;

const float LETTERS = 3.0;   // how many letters enter before the first one has

void main() {
    texel = in_texel / texture_size;
    across = in_order.y;
    float own = clamp(progress * (1.0 + LETTERS) - in_order.x * LETTERS, 0.0, 1.0);
    float eased = 1.0 - (1.0 - own) * (1.0 - own) * (1.0 - own);
    vec2 corner = in_corner;
    shows = 1.0;
    if (entrance == 1) shows = smoothstep(0.0, 1.0, progress);
    if (entrance == 2) { corner.y -= 0.6 * (1.0 - eased); shows = own; }
    if (entrance == 4) shows = progress >= 1.0 || progress > in_order.x ? 1.0 : 0.0;
    place = origin + vec3(corner * em, 0.0);
    vec3 seen = mirrored == 1 ? vec3(place.x, -place.y, place.z) : place;
    gl_Position = standing == 1 ? world_to_clip * vec4(seen, 1.0) : part_clip(vec4(place.xy, 0.0, 1.0));
}
