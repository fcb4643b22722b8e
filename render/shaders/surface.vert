#ifdef WELDED
// The indices are points, so that a point on several seams is processed only once.
#define vertexPoint uint(gl_VertexID)
#define vertexUv vec2(0.0)
#define vertexNormal vertexPoint
#else
layout(location = 0) in uint vertexPoint;
layout(location = 1) in vec2 vertexUv;
layout(location = 3) in uint vertexNormal;
#endif
#ifdef TUBE
layout(location = 2) in vec3 vertexRing;  // Fraction of the distance to the next point; profile out, along.
#endif

layout(std430, binding = 2) readonly buffer Instances { vec4 instances[]; };  // Two each, see InstanceRecord.

#ifndef DEPTH_ONLY
out vec3 toEye;
out vec3 shadowCoord;
out vec2 uv;
flat out vec4 look;
#ifdef GALLERY
flat out vec4 material;
#endif
#ifdef SMOOTH
centroid out vec3 smoothNormal;
#endif
#endif

#if defined(TUBE) || (defined(SMOOTH) && !defined(DEPTH_ONLY))
vec3 normalAt(uint index) {
  return vec3(normals[3u * index], normals[3u * index + 1u], normals[3u * index + 2u]);
}
#endif

#ifdef TUBE
// Computes position and normal; `base` and `frameBase` are the first point and first side vector of the rope.
void tubeVertex(uint base, uint frameBase, out vec3 position, out vec3 normal) {
  int k = int(vertexPoint);
  float t = vertexRing.x;
  vec3 before = tubePoint(base, k - 1);
  vec3 a = tubePoint(base, k);
  vec3 b = tubePoint(base, k + 1);
  vec3 after = tubePoint(base, k + 2);
  vec3 centre = a + 0.5 * t * ((b - before) + t * ((2.0 * before - 5.0 * a + 4.0 * b - after) +
                                                   t * (3.0 * (a - b) + after - before)));
  vec3 slope = 0.5 * ((b - before) + t * (2.0 * (2.0 * before - 5.0 * a + 4.0 * b - after) +
                                          3.0 * t * (3.0 * (a - b) + after - before)));
  vec3 side = normalAt(frameBase + vertexPoint);
  if (t > 0.0) {
    side = mix(side, normalAt(frameBase + min(vertexPoint + 1u, pointCount - 1u)), t);
  }
  vec3 tangent = unitOr(slope, vec3(0.0, 1.0, 0.0));
  side = unitOr(side - dot(side, tangent) * tangent, vec3(1.0, 0.0, 0.0));
  float angle = 6.28318530718 * vertexUv.x;
  vec3 outward = cos(angle) * side + sin(angle) * cross(tangent, side);
  normal = vertexRing.y * outward + vertexRing.z * tangent;
  position = centre + shapeRadius * normal;
}
#endif

void main() {
  uint instance = uint(gl_InstanceID);
  uint base = firstPoint + instance * pointCount;
  vec3 position;
  vec3 normal = vec3(0.0);
#ifdef TUBE
  tubeVertex(base, firstNormal + instance * pointCount, position, normal);
#else
  position = pointAt(base + vertexPoint);
#endif

#ifdef DEPTH_ONLY
#ifdef FROM_EYE
  gl_Position = frame.viewProjection * vec4(position, 1.0);
#else
  vec3 shadow = (frame.worldToShadow * vec4(position, 1.0)).xyz;
  gl_Position = vec4(2.0 * shadow.x - 1.0, 1.0 - 2.0 * shadow.y, shadow.z, 1.0);
#endif
#else
#if defined(SMOOTH) && !defined(TUBE)
  normal = normalAt(firstNormal + instance * normalCount + vertexNormal);
#endif
#ifdef SMOOTH
  smoothNormal = normal;
#endif
  toEye = frame.eye.xyz - position;
  shadowCoord = (frame.worldToShadow * vec4(position, 1.0)).xyz;
  uv = vertexUv;
  look = instances[2u * (firstInstance + instance)];
#ifdef GALLERY
  material = instances[2u * (firstInstance + instance) + 1u];
#endif
  gl_Position = frame.viewProjection * vec4(position, 1.0);
#endif
}
