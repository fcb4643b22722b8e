// Blue (-1) over grey (0) to red (1), mixed in Oklab so that equal strains look equally far apart.
vec3 strainColour(float strain) {
  const vec3 kCompressed = vec3(0.47, -0.035, -0.19);
  const vec3 kRest = vec3(0.74, 0.0, 0.004);
  const vec3 kStretched = vec3(0.53, 0.19, 0.095);
  float t = clamp(strain, -1.0, 1.0);
  return max(oklabToLinear(mix(kRest, t < 0.0 ? kCompressed : kStretched, abs(t))), 0.0);
}
