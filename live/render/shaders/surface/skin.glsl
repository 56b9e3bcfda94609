// A vertex that only one pass draws, moved by the pose as it is drawn.
#include "poses.glsl"

in vec3 in_position;
in vec3 in_normal;
in uvec4 in_joint;
in vec4 in_weight;
in int in_dancer;
#define VERTEX 1

Skinned skinned(vec3 position, vec3 normal) { return posed(in_dancer, in_joint, in_weight, position, normal); }
