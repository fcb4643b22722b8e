layout(location = 0) out vec4 result;

void main() { result = vec4(dithered(backgroundColour()), 1.0); }
