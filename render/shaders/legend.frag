in vec2 bar;
layout(location = 0) out vec4 result;

void main() {
  // Ticks at the quarters.
  float nearest = abs(bar.x - 0.25 * round(4.0 * bar.x));
  bool tick = nearest < fwidth(bar.x) && bar.y > 0.65 && abs(bar.x - 0.5) < 0.45;
#ifdef STRAIN
  vec3 colour = strainColour(2.0 * bar.x - 1.0);
#else
  vec3 colour = shareColour(bar.x);
#endif
  result = vec4(tick ? vec3(0.03) : colour, 1.0);
}
