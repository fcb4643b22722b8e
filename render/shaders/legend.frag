in vec2 bar;
layout(location = 0) out vec4 result;

void main() {
  float strain = 2.0 * bar.x - 1.0;
  // Ticks at rest and at half the range.
  float nearest = abs(strain - 0.5 * round(2.0 * strain));
  bool tick = nearest < fwidth(strain) && bar.y > 0.65 && abs(strain) < 0.9;
  result = vec4(tick ? vec3(0.03) : strainColour(strain), 1.0);
}
