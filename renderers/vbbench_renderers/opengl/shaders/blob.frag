in vec2 place;
flat in float strength;
out float open;

void main() {
    float fall = max(1.0 - dot(place, place), 0.0);
    open = 1.0 - strength * fall * fall;
}
