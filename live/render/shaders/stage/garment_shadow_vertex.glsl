// Garments flattened along the key light onto the floor map.
#include "frame.glsl"
#include "garment.glsl"
#if STYLED
#define VERTEX 1
#include "surface.glsl"
#include "styles.glsl"
flat out float casts;
#endif

out float height;

void main() {
    vec3 place = particle(int(in_cell.x), int(in_cell.y));
    height = max(place.y, 0.0);
    vec2 spot = place.xz - key_direction.xz / key_direction.y * height;
#if STYLED
    casts = presence(group_of(who(in_worn.x)));
#endif
    gl_Position = vec4(spot / stage.zw, 0.0, 1.0);
}
