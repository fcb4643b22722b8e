// A bar at the lower right, from full compression to full stretch.
out vec2 bar;

void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  vec2 size = vec2(0.22 * frame.viewport.x, max(6.0, 0.018 * frame.viewport.y));
  float margin = 0.03 * frame.viewport.y;
  vec2 pixel = frame.viewport.xy - margin - size + corner * size;
  bar = corner;
  gl_Position = vec4(2.0 * pixel.x / frame.viewport.x - 1.0, 1.0 - 2.0 * pixel.y / frame.viewport.y, 0.0, 1.0);
}
