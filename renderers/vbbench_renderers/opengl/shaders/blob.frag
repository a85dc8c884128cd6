in vec2 place;
flat in vec3 strength;
out vec2 open;

void main() {
    float cover = 1.0 - smoothstep(strength.z, 1.0, length(place));
    open = 1.0 - strength.xy * cover;
}
