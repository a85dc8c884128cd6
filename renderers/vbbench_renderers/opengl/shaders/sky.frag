in vec2 place;
layout(location = 0) out vec4 picture;
layout(location = 1) out float depth;

void main() {
    vec2 at = place - shift;
    float down = (at.y - lens.w) / lens.z;
#ifdef PANORAMA
    vec3 seen = vec3(sin(at.x * PI), down, cos(at.x * PI));
#else
    float right = (at.x - lens.y) / lens.x;
    vec3 seen = right * tilt_right.xyz + down * tilt_down.xyz + tilt_forward.xyz;
#endif
    vec2 flat_way = seen.z * heading.xy + seen.x * vec2(heading.y, -heading.x);
    picture = vec4(encode(sky(normalize(vec3(flat_way, -seen.y)))), 1.0);
    depth = 1.0 / 0.0;
}
