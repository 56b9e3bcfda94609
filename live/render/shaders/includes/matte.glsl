// What came over the surfaces: where they are, it may have hidden some of their light (below 0).
uniform sampler2D kept;    // surfaces on nothing: compressed light times cover, cover
uniform sampler2D scene;   // with the light that came over them

vec3 light_over(vec4 solid) {
    vec3 more = texelFetch(scene, ivec2(gl_FragCoord.xy), 0).rgb - solid.rgb;
    return min(more / max(1.0 - solid.rgb, 0.02), 1.0);
}
