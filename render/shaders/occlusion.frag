// Ambient occlusion from the depths of the picture: Jimenez and others 2016, "Practical realtime strategies for accurate
// indirect occlusion" (GTAO), equations 7 to 10.
layout(binding = 2) uniform sampler2D depths;

layout(location = 0) out float result;

const float kHalfPi = 1.57079632679;

float deepness(vec2 pixel) { return frame.right.w / (texelFetch(depths, ivec2(pixel), 0).r + frame.forward.w); }

vec3 placeAt(vec2 pixel) {
  vec2 inside = clamp(pixel, vec2(0.5), frame.viewport.xy - 0.5);
  return deepness(inside) * viewRay(inside);
}

// The nearer of two neighbours lies on the same surface. At the picture's edge there is one only.
vec3 along(vec3 place, vec2 pixel, vec2 step) {
  vec3 ahead = placeAt(pixel + step) - place;
  vec3 behind = place - placeAt(pixel - step);
  float forward = dot(ahead, ahead), backward = dot(behind, behind);
  return backward == 0.0 || (forward > 0.0 && forward < backward) ? ahead : behind;
}

float horizonAt(vec3 place, vec3 toEye, vec2 pixel, float low) {
  // beside the picture is nothing
  if (any(lessThan(pixel, vec2(0.0))) || any(greaterThan(pixel, frame.viewport.xy))) {
    return low;
  }
  vec3 ray = placeAt(pixel) - place;
  float distance = max(length(ray), 1e-6);
  float share = distance / frame.down.w;
  float near = clamp(1.0 - share * share, 0.0, 1.0);
  return mix(low, dot(ray / distance, toEye), near);
}

// One slice of the hemisphere through the view ray; `step` in pixels.
float visibility(vec3 place, vec3 normal, vec3 toEye, vec2 pixel, vec2 step, float jitter) {
  vec3 across = normalize(step.x * frame.right.xyz / frame.viewport.x + step.y * frame.down.xyz / frame.viewport.y);
  vec3 side = across - dot(across, toEye) * toEye;
  vec3 axis = normalize(cross(side, toEye));
  vec3 inSlice = normal - dot(normal, axis) * axis;
  float size = max(length(inSlice), 1e-4);
  float cosine = clamp(dot(inSlice, toEye) / size, 0.0, 1.0);
  float n = sign(dot(side, inSlice)) * acos(cosine);
  float low0 = cos(n + kHalfPi), low1 = cos(n - kHalfPi);
  float horizon0 = low0, horizon1 = low1;
  for (int i = 0; i < OCCLUSION_STEPS; ++i) {
    float t = (float(i) + jitter) / float(OCCLUSION_STEPS);
    vec2 offset = max(t * t, 1.5 / length(step)) * step;
    horizon0 = max(horizon0, horizonAt(place, toEye, pixel + offset, low0));
    horizon1 = max(horizon1, horizonAt(place, toEye, pixel - offset, low1));
  }
  float h0 = -acos(clamp(horizon1, -1.0, 1.0)), h1 = acos(clamp(horizon0, -1.0, 1.0));
  float sine = sin(n);
  return size * 0.25 * ((cosine + 2.0 * h0 * sine - cos(2.0 * h0 - n)) + (cosine + 2.0 * h1 * sine - cos(2.0 * h1 - n)));
}

void main() {
  vec2 pixel = gl_FragCoord.xy;
  vec3 place = placeAt(pixel);
  float depth = deepness(pixel);
  // the background is the far plane
  if (texelFetch(depths, ivec2(pixel), 0).r >= 1.0) {
    result = 1.0;
    return;
  }
  vec3 normal = normalize(cross(along(place, pixel, vec2(0.0, 1.0)), along(place, pixel, vec2(1.0, 0.0))));
  vec3 toEye = -normalize(place);
  normal = dot(normal, toEye) < 0.0 ? -normal : normal;
  float reach = 0.5 * frame.viewport.x * frame.down.w / (length(frame.right.xyz) * depth);
  reach = clamp(reach, 3.0, 0.25 * frame.viewport.x);
  // 16 directions and distances in each square of 4 x 4 pixels, which the blur averages
  ivec2 cell = ivec2(pixel) & 3;
  float turn = float((cell.x * 4 + cell.y * 7) & 15) / 16.0;
  float jitter = (float((cell.x * 7 + cell.y * 4) & 15) + 0.5) / 16.0;
  float sum = 0.0;
  for (int slice = 0; slice < OCCLUSION_SLICES; ++slice) {
    float angle = 2.0 * kHalfPi * (float(slice) + turn) / float(OCCLUSION_SLICES);
    float start = fract(jitter + 0.618034 * float(slice));
    sum += visibility(place, normal, toEye, pixel, reach * vec2(cos(angle), sin(angle)), start);
  }
  result = clamp(sum / float(OCCLUSION_SLICES), 0.0, 1.0);
}
