uniform sampler2D atlas;

in vec2 texel;
flat in int is_panel;

out vec4 shown;

void main() {
    if (is_panel == 1) {
        shown = vec4(0.02, 0.02, 0.03, 0.62);
    } else {
        shown = vec4(0.93, 0.94, 0.96, texelFetch(atlas, ivec2(texel), 0).r);
    }
}
