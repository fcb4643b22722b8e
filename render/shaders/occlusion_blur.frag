// Averages the 4 x 4 pixels around a corner of the pixel that lie on its surface.
layout(binding = 2) uniform sampler2D depths;
layout(binding = 3) uniform sampler2D occlusion;

layout(location = 0) out float result;

float deepness(ivec2 pixel) { return frame.right.w / (texelFetch(depths, pixel, 0).r + frame.forward.w); }

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy), last = ivec2(frame.viewport.xy) - 1;
  float depth = deepness(pixel), sum = 0.0, weights = 0.0;
  for (int y = -2; y < 2; ++y) {
    for (int x = -2; x < 2; ++x) {
      ivec2 at = clamp(pixel + ivec2(x, y), ivec2(0), last);
      float weight = abs(deepness(at) - depth) < 0.25 * frame.down.w ? 1.0 : 1e-3;
      sum += weight * texelFetch(occlusion, at, 0).r;
      weights += weight;
    }
  }
  result = sum / weights;
}
