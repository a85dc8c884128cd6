in vec2 place;
layout(location = 0) out vec4 picture;
layout(location = 1) out float depth;

void main() {
    vec2 at = place - shift;
    float up = (lens.w - at.y) / lens.z;
#ifdef PANORAMA
    vec2 seen = vec2(sin(at.x * PI), cos(at.x * PI));
#else
    vec2 seen = vec2((at.x - lens.y) / lens.x, 1.0);
#endif
    vec2 flat_way = seen.y * heading.xy + seen.x * vec2(heading.y, -heading.x);
    picture = vec4(encode(sky(normalize(vec3(flat_way, up)))), 1.0);
    depth = 1.0 / 0.0;
}
