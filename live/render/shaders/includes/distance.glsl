// How far the picture shows something at a place, along the camera's axis: surfaces, else floor and back wall. After
// frame.glsl; NEAR, FAR and WALL_BEHIND are constants of the program.
uniform sampler2D depth;

const float FARTHEST = 60.0;

vec3 ray_at(vec2 at) { return ray_corner.xyz + ray_right.xyz * at.x + ray_up.xyz * at.y; }

float distance_at(vec2 at) {
    float z = textureLod(depth, at, 0.0).r;
    if (z < 1.0) return 2.0 * FAR * NEAR / (FAR + NEAR - (z * 2.0 - 1.0) * (FAR - NEAR));
    vec3 ray = ray_at(at);
    float to_floor = ray.y < -1e-4 ? -eye.y / ray.y : FARTHEST;
    float to_wall = ray.z < -1e-4 ? (-stage.y - WALL_BEHIND - eye.z) / ray.z : FARTHEST;
    to_wall = to_wall > 0.0 ? to_wall : FARTHEST;
    return clamp(min(to_floor, to_wall), NEAR, FARTHEST);
}
