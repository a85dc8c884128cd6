uniform sampler2DShadow people_shadow;
uniform sampler2DShadow fixed_shadow;
uniform sampler2D ground_map;  // over the ground: share of the sun that people let through, and of the sky

// Where to look a point up in a shadow map; lifted off its surface so that it does not shade itself.
vec3 in_map(vec3 point, vec3 normal, vec4 map, float lift) {
    return along_sun(point + normal * lift, map) * vec3(0.5, 0.5, 1.0) + vec3(0.5, 0.5, -0.0005);
}

vec3 on_ground(vec3 point) {
    return vec3((point.xy - window.xy) * window.z * 0.5 + 0.5, point.z * 3.0);
}

// Light of sky and ground on a surface.
vec3 ambient(vec3 normal) {
    return mix(ground_glow.rgb, mix(horizon.rgb, zenith.rgb, 0.6), normal.z * 0.5 + 0.5);
}

vec3 sky(vec3 direction) {
    float up = max(direction.z, 0.0);
    float along = max(dot(direction, sun_direction.xyz), 0.0);
    float near = along * along;
    near *= near;
    near *= near;
    float halo = near * near * near * near;
    float glow = 0.04 * near + 0.12 * halo + 2.0 * smoothstep(0.99986, 0.99993, along);
    return mix(horizon.rgb, zenith.rgb, sqrt(up)) + sun_colour.rgb * glow;
}

vec3 through_air(vec3 colour, float range) {
    return mix(horizon.rgb, colour, exp(-range / sun_direction.w));
}

// Linear light to sRGB; the roots approximate the power to 0.3 %.
vec3 encode(vec3 light) {
    light = clamp(light, 0.0, 1.0);
    vec3 a = sqrt(light), b = sqrt(a), c = sqrt(b);
    return 0.662002687 * a + 0.684122060 * b - 0.323583601 * c - 0.0225411470 * light;
}
