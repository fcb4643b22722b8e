// As shareColour() of overlay.h.
vec3 shareColour(float share) {
  float t = clamp(share, 0.0, 1.0);
  float hue = 4.9 - 3.0 * t;
  return max(oklabToLinear(vec3(0.33 + 0.59 * t, 0.13 * cos(hue), 0.13 * sin(hue))), 0.0);
}
