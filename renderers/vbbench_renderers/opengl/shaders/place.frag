uniform sampler2DArray textures;
in vec3 world;
in vec3 upright;
in vec3 tint;
in vec3 at;
layout(location = 0) out vec4 picture;
layout(location = 1) out float depth;

void main() {
    vec3 albedo = tint;
    vec3 painted = texture(textures, at).rgb;
    painted = painted * (painted * (painted * 0.305306011 + 0.682171111) + 0.012522878);  // sRGB to linear, to 0.2 %
    if (at.z > -0.5) albedo *= painted;
    vec3 normal = normalize(upright);
    if (dot(normal, eye.xyz - world) < 0.0) normal = -normal;
    vec3 light = albedo * light_on(world, normal, sunlight(world, normal));
    picture = vec4(encode(through_air(light, world)), 1.0);
    depth = 1.0 / gl_FragCoord.w;
}
