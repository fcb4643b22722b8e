// A bar of colours, two triangles as a strip.
uniform vec4 rectangle;  // Pixels from the upper left: left, top, width, height.

out vec2 bar;

void main() {
  bar = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  vec2 pixel = rectangle.xy + bar * rectangle.zw;
  gl_Position = vec4(2.0 * pixel.x / frame.viewport.x - 1.0, 1.0 - 2.0 * pixel.y / frame.viewport.y, 0.0, 1.0);
}
