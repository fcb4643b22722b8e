// Ottosson 2020, "A perceptual color space for image processing".
vec3 oklabToLinear(vec3 lab) {
  vec3 root = vec3(dot(lab, vec3(1.0, 0.3963377774, 0.2158037573)),
                   dot(lab, vec3(1.0, -0.1055613458, -0.0638541728)),
                   dot(lab, vec3(1.0, -0.0894841775, -1.2914855480)));
  vec3 lms = root * root * root;
  return vec3(dot(lms, vec3(4.0767416621, -3.3077115913, 0.2309699292)),
              dot(lms, vec3(-1.2684380046, 2.6097574011, -0.3413193965)),
              dot(lms, vec3(-0.0041960863, -0.7034186147, 1.7076147010)));
}

// Blue (-1) over grey (0) to red (1), mixed in Oklab, where equal steps look equal.
vec3 strainColour(float strain) {
  const vec3 kCompressed = vec3(0.47, -0.035, -0.19);
  const vec3 kRest = vec3(0.74, 0.0, 0.004);
  const vec3 kStretched = vec3(0.53, 0.19, 0.095);
  float t = clamp(strain, -1.0, 1.0);
  return max(oklabToLinear(mix(kRest, t < 0.0 ? kCompressed : kStretched, abs(t))), 0.0);
}

// Equal to shareColour() of overlay.h.
vec3 shareColour(float share) {
  float t = clamp(share, 0.0, 1.0);
  float hue = 4.9 - 3.0 * t;
  return max(oklabToLinear(vec3(0.33 + 0.59 * t, 0.13 * cos(hue), 0.13 * sin(hue))), 0.0);
}
