flat in vec3 colour;
uniform float opacity;
layout(location = 0) out vec4 result;

vec3 linear(vec3 srgb) { return mix(srgb / 12.92, pow((srgb + 0.055) / 1.055, vec3(2.4)), greaterThan(srgb, vec3(0.04045))); }

void main() { result = vec4(linear(colour), opacity); }
