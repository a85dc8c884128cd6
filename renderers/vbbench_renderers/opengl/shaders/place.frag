uniform sampler2DArray textures;
in vec3 shaded;
in vec3 sunlit;
in vec3 at;
in vec3 fixed_at;
in vec3 ground_at;
layout(location = 0) out vec4 picture;
layout(location = 1) out float depth;

void main() {
    depth = 1.0 / gl_FragCoord.w;
    vec3 painted = texture(textures, at).rgb;
    painted = painted * (painted * (painted * 0.305306011 + 0.682171111) + 0.012522878);  // sRGB to linear, to 0.2 %
    if (at.z < -0.5) painted = vec3(1.0);
    vec2 open = mix(texture(ground_map, ground_at.xy).rg, vec2(1.0), clamp(ground_at.z, 0.0, 1.0));
    float lit = texture(fixed_shadow, fixed_at) * open.x * (0.5 + 0.5 * open.y);
    vec3 light = painted * (shaded * open.y + sunlit * lit);
    picture = vec4(encode(through_air(light, depth)), 1.0);
}
