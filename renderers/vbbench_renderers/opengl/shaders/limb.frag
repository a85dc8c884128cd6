in vec3 world;
in vec3 upright;
in vec3 local;
in vec3 tint;
flat in vec4 first;
flat in vec4 second;
flat in float who;
layout(location = 0) out vec4 picture;
layout(location = 1) out vec2 truth;

bool shows_second() {
    int pattern = int(first.w + 0.5);
    if (pattern == 0) return false;
    if (pattern == 1) return fract(RINGS_PER_M * local.z) < 0.5;
    if (pattern == 2) return fract(STRIPES_ROUND * atan(local.y, local.x) / (2.0 * PI)) < 0.5;
    if (pattern == 3) return (fract(CHECKS_PER_M * local.x) < 0.5) != (fract(CHECKS_PER_M * local.z) < 0.5);
    return local.z < 0.0;
}

void main() {
    vec3 albedo = tint * (shows_second() ? second.rgb : first.rgb);
    vec3 normal = normalize(upright);
    float lit = sunlight(world, normal);
    vec3 light = albedo * light_on(world, normal, lit) + second.w * mirrored(world, normal, lit);
    picture = vec4(encode(through_air(light, world)), 1.0);
    truth = vec2(who + 1.0, 1.0 / gl_FragCoord.w);
}
