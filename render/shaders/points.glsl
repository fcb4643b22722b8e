// Positions are packed, 12 bytes each, so an array of vec3 (16 bytes each) does not match.
layout(std430, binding = 0) readonly buffer Points { float points[]; };

vec3 pointAt(uint index) {
  return vec3(points[3u * index], points[3u * index + 1u], points[3u * index + 2u]);
}

#ifdef NORMALS_ACCESS
layout(std430, binding = 1) NORMALS_ACCESS buffer Normals { float normals[]; };
#endif
