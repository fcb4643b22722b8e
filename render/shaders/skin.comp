// A place of a skin is the weighted sum of its points. One invocation per place.
layout(local_size_x = 64) in;

#ifdef DENSE
layout(std430, binding = 5) readonly buffer Weights { float weights[]; };  // By point, then by place.
#else
layout(std430, binding = 4) readonly buffer First { uint first[]; };      // Into Weights, by place.
layout(std430, binding = 5) readonly buffer Weights { uvec2 weights[]; };  // A point and the bits of its weight.
#endif
layout(std430, binding = 6) writeonly buffer Places { float places[]; };

uniform uint invocations;
uniform uint firstPlace;
uniform uint skinnedPointCount;  // Per instance.

void main() {
  uint index = gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * gl_NumWorkGroups.x * 64u;
  if (index >= invocations) {
    return;
  }
  uint instance = index / skinnedPointCount;
  uint place = index - instance * skinnedPointCount;
  uint base = firstPoint + instance * pointCount;
  vec3 sum = vec3(0.0);
#ifdef DENSE
  for (uint k = 0u; k < pointCount; ++k) {
    sum += weights[k * skinnedPointCount + place] * pointAt(base + k);
  }
#else
  for (uint i = first[place]; i < first[place + 1u]; ++i) {
    uvec2 entry = weights[i];
    sum += uintBitsToFloat(entry.y) * pointAt(base + entry.x);
  }
#endif
  uint at = 3u * (firstPlace + index);
  places[at] = sum.x;
  places[at + 1u] = sum.y;
  places[at + 2u] = sum.z;
}
