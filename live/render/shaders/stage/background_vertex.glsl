// A rectangle that stands in the stage or lies on its floor, its image in the floor, or the whole picture.
#include "frame.glsl"
uniform vec3 origin;      // upper left corner as its front is seen [m]
uniform vec3 across;      // to the right edge [m]; 0: the whole picture
uniform vec3 down;        // to the lower edge [m]
uniform vec2 crop;        // how much of the picture's width and height is seen
uniform float depth;      // of the whole picture: 1 behind everything, -1 before it
uniform int mirrored;     // 1: in the floor

out vec2 texel;
out vec2 inside;          // from the lower left corner
out vec3 place;

void main() {
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    inside = corner;
    texel = vec2(0.5) + (vec2(corner.x, 1.0 - corner.y) - 0.5) * crop;
    place = origin + across * corner.x + down * (1.0 - corner.y);
    vec3 seen = mirrored == 1 ? vec3(place.x, -place.y, place.z) : place;
    gl_Position = across == vec3(0.0) ? part_clip(vec4(corner * 2.0 - 1.0, depth, 1.0)) : world_to_clip * vec4(seen, 1.0);
}
