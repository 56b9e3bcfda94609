// Uniforms that all programs share, filled once a frame; the parameters themselves are functions: light_haze().
#include "picture_values.glsl"
layout(std140) uniform Frame {
    mat4 world_to_clip;
    vec4 ray_corner;      // eye ray through the lower left corner of what is drawn; w: pixels of a metre, a metre away
    vec4 ray_right;       // added from the left to the right edge
    vec4 ray_up;          // added from the lower to the upper edge
    vec4 eye;             // xyz [m], w: distance at which the haze begins [m]
    vec4 key_direction;   // xyz: towards the light, w: pulse of the beat, 0 to 1
    vec4 key_light;       // rgb, w: brightness
    vec4 rim_light;       // rgb
    vec4 stage;           // half width, half depth [m], half width and half depth of the floor map [m]
    vec4 edge;            // half width, half depth of the stage now [m], 0 to 1: how far that is not the scene's, phase of the beat
    vec4 picture;         // of what is drawn, the picture or a part of it: width, height [pixels], 1 / width, 1 / height
    vec4 side_left;       // rgb
    vec4 side_right;      // rgb
    vec4 back_light;      // rgb, w: how much the vignette takes at the film curve
    vec4 beam_light;      // rgb, w: beats, coming back after 64
    vec4 spot_place[4];   // x, z, radius [m], strength
    vec4 spot_light[4];   // rgb; w: of the first 1 if any is lit, of the next two the first lit one and the one after the last
    vec4 worlds;          // shares of the worlds: studio, paper, constellation, water
    vec4 open_sky;        // shares of dusk and haze; how far the key light falls everywhere alike
    vec4 fill_above;      // rgb
    vec4 fill_below;      // rgb
    vec4 gobo;            // cosine and sine of its angle / its size [1/m], sum of its patterns' amounts
    vec4 whole_picture;   // the same of the whole picture
    vec4 picture_part;    // what is drawn: left, bottom [pixels of the whole picture], shares of its width and height
};

// From 0, 0 (lower left) to 1, 1 in what is drawn and in the whole picture: the same places unless a part is drawn.
vec2 picture_place(vec2 at) { return at * picture_part.zw + picture_part.xy * whole_picture.zw; }
vec2 part_place(vec2 place) { return (place - picture_part.xy * whole_picture.zw) / picture_part.zw; }

// Where the middle of the whole picture is in the clip space of the part.
vec2 whole_middle() { return (1.0 - 2.0 * picture_part.xy * whole_picture.zw) / picture_part.zw - 1.0; }
// From the whole picture's clip space to that of the part.
vec4 part_clip(vec4 clip) { return vec4(clip.xy / picture_part.zw + whole_middle() * clip.w, clip.zw); }
// The way of a direction in clip space over the picture, wherever the part is in it.
vec2 clip_way(vec4 direction) { return direction.xy - whole_middle() * direction.w; }

float share_studio() { return worlds.x; }
float share_paper() { return worlds.y; }
float share_constellation() { return worlds.z; }
float share_water() { return worlds.w; }
float share_dusk() { return open_sky.x; }

float square(float x) { return x * x; }
vec3 square3(vec3 x) { return x * x; }

// How much of the key light reaches a place on the stage: a wide wash with soft edges.
float key_pool(vec2 place) {
    vec2 at = place / (edge.xy + vec2(0.6, 0.9));
    float reach = dot(at, at);
    return mix(1.0 / (1.0 + reach * reach * 0.55), 1.0, open_sky.z);
}

// The spots that may be lit, for a loop that need not look at all.
int spots_begin() { return int(spot_light[1].w); }
int spots_end() { return int(spot_light[2].w); }

// Follow spots: lamps high in front of the stage, a firm edge around whom they follow.
vec3 spot_lamp(int k) { return vec3(spot_place[k].x * 0.6 + (float(k) - 1.5) * 1.2, 9.5, stage.y + 4.0); }

// How much of a spot reaches a place: 1 within its radius around the line from its lamp to her thighs, so that its pool
// lies around her feet.
float spot_reach(int k, vec3 place) {
    vec3 lamp = spot_lamp(k), to = vec3(spot_place[k].x, 0.7, spot_place[k].y) - lamp;
    float far = length(to);
    vec3 way = place - lamp;
    float along = dot(way, to) / far;
    float off = length(way - to * (along / far));
    float radius = spot_place[k].z * along / far;
    return 1.0 - smoothstep(radius * 0.82, radius * 1.06, off);
}

float answer() { return 1.0 + light_pulse() * key_direction.w; }

float haze_at(vec3 place) {
    return 1.0 - exp(-light_haze() * max(distance(place, eye.xyz) - eye.w, 0.0));
}

// Light that the haze itself sends to the eye from the depth of the stage.
vec3 haze_light(float height) {
    return light_background() + rim_light.rgb * 0.030 * exp(-max(height, 0.0) * 0.5);
}
