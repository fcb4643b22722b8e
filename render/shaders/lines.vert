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
  gl_Position = wideLineCorner(p, q, corner, frame.viewport.z);
}
