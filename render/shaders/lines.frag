flat in float strain;
layout(location = 0) out vec4 result;

void main() { result = vec4(strainColour(strain), 1.0); }
