// A vertical gradient, shared by the backdrop and by the floor that fades into it.
vec3 backgroundColour() {
  float down = clamp(gl_FragCoord.y / frame.viewport.y, 0.0, 1.0);
  return mix(frame.backgroundTop.rgb, frame.backgroundBottom.rgb, smoothstep(0.0, 1.0, down));
}

// Noise without a visible pattern, 0 to 1 (Jimenez 2014, "Next generation post processing in Call of Duty", slide 123).
float pixelNoise(vec2 pixel) { return fract(52.9829189 * fract(dot(floor(pixel), vec2(0.06711056, 0.00583715)))); }

// Adds noise of half a level up or down: such a gentle gradient would show bands in 8 bits.
// A level of sRGB is about 2.2 sqrt(c) / 255 of linear light at c.
vec3 dithered(vec3 colour) {
  return max(colour + (pixelNoise(gl_FragCoord.xy) - 0.5) * 2.2 / 255.0 * sqrt(colour), 0.0);
}
