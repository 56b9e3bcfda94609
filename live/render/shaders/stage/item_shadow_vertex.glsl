// An item flattened along the key light onto the floor map.
#include "frame.glsl"
in vec3 in_position;
out float height;

void main() {
    height = max(in_position.y, 0.0);
    vec2 spot = in_position.xz - key_direction.xz / key_direction.y * height;
    gl_Position = vec4(spot / stage.zw, 0.0, 1.0);
}
