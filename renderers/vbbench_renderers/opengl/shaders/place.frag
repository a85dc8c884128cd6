uniform sampler2DArray textures;
in vec3 world;
in vec3 upright;
in vec3 tint;
in vec3 at;
layout(location = 0) out vec4 picture;
layout(location = 1) out vec2 truth;

void main() {
    vec3 albedo = tint;
    vec3 painted = texture(textures, at).rgb;
    painted = painted * (painted * (painted * 0.305306011 + 0.682171111) + 0.012522878);  // sRGB to linear, to 0.2 %
    if (at.z > -0.5) albedo *= painted;
    vec3 normal = normalize(upright);
    if (dot(normal, eye.xyz - world) < 0.0) normal = -normal;
    vec3 light = shade(albedo, world, normal, 0.0);
    picture = vec4(encode(through_air(light, world)), 1.0);
    truth = vec2(-1.0, 1.0 / gl_FragCoord.w);
}
