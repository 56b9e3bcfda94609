// Three layers by the height of what casts the shadow: the higher, the softer it is drawn later.
in float height;
#if STYLED
flat in float casts;
#endif
out vec4 layers;

void main() {
    layers = vec4(1.0 - smoothstep(0.10, 0.30, height), 1.0 - smoothstep(0.55, 0.95, height), 1.0, 1.0);
#if STYLED
    layers *= casts;
#endif
}
