// The white studio: a cove, whose floor rises into the wall without a corner.
#include "backdrop.glsl"

const float WALL_AT = 7.0;      // behind the stage [m]
const float FILLET = 6.5;       // radius of the cove [m]

void main() {
    vec3 direction = normalize(ray);
    float wall_z = -stage.y - WALL_AT;
    float to_floor = floor_reach(direction);
    float to_wall = direction.z < -1e-4 ? (wall_z - eye.z) / direction.z : 1e4;
    vec3 ground = eye.xyz + direction * min(to_floor, 200.0), wall = eye.xyz + direction * min(to_wall, 200.0);
    // how far up the cove a place is: 0 on the floor, 1 on the upright wall
    float up = to_floor < to_wall ? 0.5 * smoothstep(wall_z + FILLET, wall_z, ground.z)
                                  : 0.5 + 0.5 * smoothstep(0.0, FILLET, wall.y);
    vec3 p = to_floor < to_wall ? ground : wall;
    vec2 off = p.xz / (stage.xy * 1.5 + 3.0);
    float pool = 1.0 / (1.0 + 0.30 * dot(off, off));
    float high = max(p.y - 2.0, 0.0);
    float lit = mix(1.06 * pool + 0.18, 0.98 / (1.0 + 0.006 * high * high), up * up * (3.0 - 2.0 * up));
    // the cove itself is a little darker: it faces neither lamp
    lit *= 1.0 - 0.04 * exp(-square((up - 0.42) / 0.28));
    // farther away, and all around, the white is even: a view from the back of the stage has no end of the room
    float far = max(length(p.xz) / (length(stage.xy) + WALL_AT), p.y * 0.05);
    lit = mix(lit, 0.90, smoothstep(1.0, 2.6, far));
    vec3 white = light_background() * (key_light.rgb * 0.75 + fill_above.rgb * 0.75);
    keep(white * lit, 1.0 - smoothstep(0.35, 0.75, up));
}
