// A normal is the normalised sum of the cross products of its triangles. Their length is twice the area, so the triangles
// are weighted by area. One invocation per normal, so that no two threads add to the same sum.
layout(local_size_x = 64) in;

layout(std430, binding = 4) readonly buffer Offsets { uint offsets[]; };  // Into Corners, by normal.
layout(std430, binding = 5) readonly buffer Corners { uint corners[]; };  // The three points of a triangle.

uniform uint invocations;

void main() {
  uint index = gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * gl_NumWorkGroups.x * 64u;
  if (index >= invocations) {
    return;
  }
  uint local = index % normalCount;
  uint base = firstPoint + index / normalCount * pointCount;
  vec3 sum = vec3(0.0);
  for (uint i = offsets[local]; i < offsets[local + 1u]; ++i) {
    vec3 centre = pointAt(base + corners[3u * i]);
    sum += cross(pointAt(base + corners[3u * i + 1u]) - centre, pointAt(base + corners[3u * i + 2u]) - centre);
  }
  float lengthSquared = dot(sum, sum);
  vec3 normal = lengthSquared > 0.0 ? sum * inversesqrt(lengthSquared) : vec3(0.0, 1.0, 0.0);
  uint at = 3u * (firstNormal + index);
  normals[at] = normal.x;
  normals[at + 1u] = normal.y;
  normals[at + 2u] = normal.z;
}
