// A tube follows a Catmull-Rom curve through its points; the ends repeat their last point.
vec3 tubePoint(uint base, int k) {
  return pointAt(base + uint(clamp(k, 0, int(pointCount) - 1)));
}

// Returns the unit vector, or `fallback` where neighbouring points coincide.
vec3 unitOr(vec3 v, vec3 fallback) {
  float lengthSquared = dot(v, v);
  return lengthSquared > 1e-20 ? v * inversesqrt(lengthSquared) : fallback;
}
