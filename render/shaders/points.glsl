// Positions are packed, 12 bytes each, so a vec3 array (16 bytes each) cannot describe them.
layout(std430, binding = 0) readonly buffer Points { float points[]; };

vec3 pointAt(uint index) {
  return vec3(points[3u * index], points[3u * index + 1u], points[3u * index + 2u]);
}
