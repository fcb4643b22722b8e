// Two entries per line: one end and the bits of the colour; the other end and the width in pixels.
layout(std430, binding = 3) readonly buffer Lines { vec4 ends[]; };

flat out vec3 colour;

#ifdef ON_SCREEN
// Ends in pixels from the upper left. The stroke ends where the line does.
vec4 strokeCorner(vec2 from, vec2 to, uint corner, float width) {
  vec2 along = 0.5 * width * normalize(to - from);
  bool atEnd = corner == 1u || corner == 2u || corner == 4u;
  float side = corner == 2u || corner == 4u || corner == 5u ? 1.0 : -1.0;
  vec2 pixel = (atEnd ? to : from) + side * vec2(-along.y, along.x);
  return vec4(2.0 * pixel.x / frame.viewport.x - 1.0, 1.0 - 2.0 * pixel.y / frame.viewport.y, 0.0, 1.0);
}
#endif

void main() {
  uint line = uint(gl_VertexID) / 6u;
  vec4 from = ends[2u * line];
  vec4 to = ends[2u * line + 1u];
  colour = unpackUnorm4x8(floatBitsToUint(from.w)).rgb;
  float width = to.w > 0.0 ? to.w : frame.viewport.z;
#ifdef ON_SCREEN
  gl_Position = strokeCorner(from.xy, to.xy, uint(gl_VertexID) % 6u, width);
#else
  gl_Position = wideLineCorner(from.xyz, to.xyz, uint(gl_VertexID) % 6u, width);
  // Lines on a surface must be visible: this moves them nearer by 1 cm at 5 m (with the usual near plane).
  gl_Position.z -= 2e-5 * gl_Position.w;
#endif
}
