// Computes a side vector, perpendicular to the rope, for each point. It is carried along from the first point without
// twist. Each depends on the one before, so one invocation computes a whole rope.
layout(local_size_x = 64) in;

uniform uint invocations;

vec3 acrossFrom(vec3 tangent) {
  vec3 size = abs(tangent);
  vec3 axis = size.x <= size.y && size.x <= size.z ? vec3(1.0, 0.0, 0.0)
              : size.y <= size.z                   ? vec3(0.0, 1.0, 0.0)
                                                   : vec3(0.0, 0.0, 1.0);
  return normalize(axis - dot(axis, tangent) * tangent);
}

void main() {
  uint rope = gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * gl_NumWorkGroups.x * 64u;
  if (rope >= invocations) {
    return;
  }
  uint base = firstPoint + rope * pointCount;
  vec3 tangent = unitOr(tubePoint(base, 1) - tubePoint(base, 0), vec3(0.0, 1.0, 0.0));
  vec3 side = acrossFrom(tangent);
  for (int k = 0; k < int(pointCount); ++k) {
    tangent = unitOr(tubePoint(base, k + 1) - tubePoint(base, k - 1), tangent);
    side = unitOr(side - dot(side, tangent) * tangent, acrossFrom(tangent));
    uint at = 3u * (firstNormal + rope * pointCount + uint(k));
    normals[at] = side.x;
    normals[at + 1u] = side.y;
    normals[at + 2u] = side.z;
  }
}
