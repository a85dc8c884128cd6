// The camera. Row 0 comes first in memory, so that clip y points down.
vec4 project(vec3 point, float base) {
    vec2 seen = relative(point.xy);
#ifdef PANORAMA
    // Equidistant columns: w is the range. Azimuths count from `base` so that no triangle is torn at the seam.
    float w = length(seen);
    float turn = atan(seen.x, seen.y) - base;
    float x = (base + turn - 2.0 * PI * round(turn / (2.0 * PI))) / PI * w;
    float down = eye.z - point.z;
#else
    vec3 level = vec3(seen.x, eye.z - point.z, seen.y);
    float w = dot(tilt_forward.xyz, level);
    float x = lens.x * dot(tilt_right.xyz, level) + lens.y * w;
    float down = dot(tilt_down.xyz, level);
#endif
    float y = lens.z * down + lens.w * w;
    float z = w - 2.0 * eye.w;  // near at eye.w, far at infinity
    return vec4(vec2(x, y) + shift * w, z, w);
}
