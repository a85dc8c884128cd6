in vec4 local;
in vec4 mirrored;
in vec3 tint;
in vec3 around;
in vec3 map;
flat in vec4 first;
flat in vec3 second;
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
    float range = 1.0 / gl_FragCoord.w;
    vec3 albedo = tint * (shows_second() ? second : first.rgb);
    float lit = texture(people_shadow, map);
    vec3 light = albedo * (around + sun_colour.rgb * (lit * max(local.w, 0.0)));
    light += mirrored.rgb + sun_colour.rgb * (mirrored.w * lit);
    picture = vec4(encode(through_air(light, range)), 1.0);
    truth = vec2(who + 1.0, range);
}
