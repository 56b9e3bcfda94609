// The dancers flattened along the key light onto the floor map.
#include "frame.glsl"
#include "skin.glsl"

out float height;

void main() {
    vec3 place = skinned(in_position, in_normal).place;
    height = max(place.y, 0.0);
    vec2 spot = place.xz - key_direction.xz / key_direction.y * height;
    gl_Position = vec4(spot / stage.zw, 0.0, 1.0);
}
