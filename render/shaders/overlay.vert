// Two entries a line: an end and the bits of the colour; the other end and the width in pixels.
layout(std430, binding = 3) readonly buffer Lines { vec4 ends[]; };

flat out vec3 colour;

void main() {
  uint line = uint(gl_VertexID) / 6u;
  vec4 from = ends[2u * line];
  vec4 to = ends[2u * line + 1u];
  colour = unpackUnorm4x8(floatBitsToUint(from.w)).rgb;
  float width = to.w > 0.0 ? to.w : frame.viewport.z;
  gl_Position = wideLineCorner(from.xyz, to.xyz, uint(gl_VertexID) % 6u, width);
  // What lies on a surface is to be seen: this brings it nearer by 1 cm at 5 m (with the usual near plane).
  gl_Position.z -= 2e-5 * gl_Position.w;
}
