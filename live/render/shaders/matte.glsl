// What came over the surfaces was blended with ONE, ONE_MINUS_SRC_COLOR: here is what it was.
uniform sampler2D kept;    // surfaces on nothing: compressed light times cover, cover
uniform sampler2D scene;   // with the light that came over them

vec3 light_over(vec4 solid) {
    vec3 more = texelFetch(scene, ivec2(gl_FragCoord.xy), 0).rgb - solid.rgb;
    return clamp(more / max(1.0 - solid.rgb, 0.02), 0.0, 1.0);
}
