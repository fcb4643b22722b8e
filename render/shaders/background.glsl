// A vertical gradient, shared by the backdrop and by the floor that fades into it.
vec3 backgroundColour() {
  float down = clamp(gl_FragCoord.y / frame.viewport.y, 0.0, 1.0);
  return mix(frame.backgroundTop.rgb, frame.backgroundBottom.rgb, smoothstep(0.0, 1.0, down));
}
