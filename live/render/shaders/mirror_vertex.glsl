// The dancers seen in the floor: upside down, lit simply.
#include "frame.glsl"
#include "skin.glsl"
#include "surface.glsl"

out vec3 light;
out float height;

void main() {
    Skinned skin = skinned(in_position, in_normal);
    height = skin.place.y;
    vec3 n = skin.normal;
    vec3 cloth = surface(in_position, int(in_dancer)).rgb;
    cloth *= cloth;
    float key = max(dot(n, key_direction.xyz), 0.0) * key_pool(skin.place.xz);
    float rim = max(-n.z, 0.0) + 0.4 * abs(n.x);
    light = cloth * (key_light.rgb * key * 2.0 + rim_light.rgb * (rim * 0.6 + rim_light.w));
    gl_Position = world_to_clip * vec4(skin.place.x, -skin.place.y, skin.place.z, 1.0);
}
