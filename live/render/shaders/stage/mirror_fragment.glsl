in vec3 light;
in float height;
out vec4 shown;

void main() {
    if (height < 0.0) discard;
    shown = vec4(sqrt(light * exp(-height * 1.7) * 0.30), 1.0);
}
