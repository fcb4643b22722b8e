// A bar of colours.
uniform vec4 place;  // Pixels from the upper left: left, top, width, height.

out vec2 bar;

void main() {
  bar = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  vec2 pixel = place.xy + bar * place.zw;
  gl_Position = vec4(2.0 * pixel.x / frame.viewport.x - 1.0, 1.0 - 2.0 * pixel.y / frame.viewport.y, 0.0, 1.0);
}
