// An item's surface, to be lit later, as gbuffer_fragment.glsl has it.
in vec3 place;
in vec3 facing;
in vec4 colour;

layout(location = 0) out vec4 cover;
layout(location = 1) out vec4 shape;
layout(location = 2) out vec4 who;   // nobody; goes nowhere where nobody asks

void main() {
    cover = colour;
    shape = vec4(normalize(facing) * 0.5 + 0.5, 0.15);
    who = vec4(0.0, 0.0, 0.0, 1.0);
}
