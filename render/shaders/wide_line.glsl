// A corner of a line drawn as a rectangle with a width in pixels: wide lines are optional in OpenGL. `corner` is 0 to 5,
// in two triangles.
vec4 wideLineCorner(vec3 p, vec3 q, uint corner, float width) {
  vec4 a = frame.viewProjection * vec4(p, 1.0);
  vec4 b = frame.viewProjection * vec4(q, 1.0);
  // A point behind the eye cannot be projected: cut the line at the near plane (z = 0).
  if (a.z < 0.0 && b.z > 0.0) {
    a = mix(a, b, a.z / (a.z - b.z));
  } else if (b.z < 0.0 && a.z > 0.0) {
    b = mix(b, a, b.z / (b.z - a.z));
  }
  vec2 along = (b.xy / b.w - a.xy / a.w) * frame.viewport.xy;
  along = dot(along, along) > 1e-12 ? normalize(along) : vec2(1.0, 0.0);
  bool atEnd = corner == 1u || corner == 2u || corner == 4u;
  float side = corner == 2u || corner == 4u || corner == 5u ? 1.0 : -1.0;
  vec4 end = atEnd ? b : a;
  vec2 offset = side * width * vec2(-along.y, along.x) / frame.viewport.xy;
  return end + vec4(offset * end.w, 0.0, 0.0);
}
