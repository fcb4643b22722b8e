in vec3 shadowCoord;
in vec2 uv;
flat in vec4 look;

layout(binding = 0) uniform sampler2DArray textures;

#ifdef GRID
// Fraction of a window of one pixel around x that is covered by lines of a width at every integer.
float lineCoverage(float x, float width, float pixel) {
  float window = max(pixel, 1e-6);
  float low = x - 0.5 * window + 0.5 * width;
  float high = low + window;
  float covered = floor(high) * width + min(fract(high), width) - floor(low) * width - min(fract(low), width);
  return clamp(covered / window, 0.0, 1.0);
}

vec3 gridColour(vec3 base) {
  vec2 pixel = fwidth(uv);
  float fine = max(lineCoverage(uv.x, 0.022, pixel.x), lineCoverage(uv.y, 0.022, pixel.y));
  // The checker is a product of two square waves, each averaged over the pixel like the lines.
  vec2 wave = 1.0 - 2.0 * vec2(lineCoverage(0.5 * uv.x + 0.25, 0.5, 0.5 * pixel.x),
                               lineCoverage(0.5 * uv.y + 0.25, 0.5, 0.5 * pixel.y));
  return base * (1.0 - 0.07 * (0.5 - 0.5 * wave.x * wave.y)) * (1.0 - 0.22 * fine);
}
#endif

vec3 surfaceColour() {
  vec3 colour = look.rgb;
#ifdef GRID
  colour = gridColour(colour);
#endif
#ifdef TEXTURED
  // The layer is below 0 for instances without a texture.
  vec3 texel = texture(textures, vec3(uv, look.a)).rgb;
  colour *= look.a >= 0.0 ? texel : vec3(1.0);
#endif
  return colour;
}
