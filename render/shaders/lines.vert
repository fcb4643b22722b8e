// Each line becomes a rectangle of some pixels' width: wide lines proper are optional in OpenGL.
layout(std430, binding = 3) readonly buffer Lines { uint lines[]; };  // Two points, 1 / rest length.

flat out float strain;

void main() {
  uint line = uint(gl_VertexID) / 6u;
  uint corner = uint(gl_VertexID) % 6u;
  uint base = firstPoint + uint(gl_InstanceID) * pointCount;
  vec3 p = pointAt(base + lines[3u * line]);
  vec3 q = pointAt(base + lines[3u * line + 1u]);
  float perRest = uintBitsToFloat(lines[3u * line + 2u]);
  strain = perRest > 0.0 ? (distance(p, q) * perRest - 1.0) * frame.viewport.w : 0.0;

  vec4 a = frame.viewProjection * vec4(p, 1.0);
  vec4 b = frame.viewProjection * vec4(q, 1.0);
  // A point behind the eye has no place on the screen: cut the line at the near plane (z = 0).
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
  vec2 offset = side * frame.viewport.z * vec2(-along.y, along.x) / frame.viewport.xy;
  gl_Position = end + vec4(offset * end.w, 0.0, 0.0);
}
