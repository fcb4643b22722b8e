// The gallery's look of a surface: GGX highlights, shadows whose edges widen with distance, light that passes through
// jelly, ambient occlusion.
flat in vec4 material;  // Roughness, metalness, translucency (m), threads per unit of uv.

layout(binding = 1) uniform sampler2D shadowMap;
layout(binding = 2) uniform sampler2D openness;  // 1: nothing near hides the surroundings.

layout(location = 0) out vec4 result;

const float kGoldenAngle = 2.39996323;

// Place i of n on a disk of radius 1, evenly spread.
vec2 onDisk(int i, int n, float turn) {
  float angle = kGoldenAngle * float(i) + turn;
  return sqrt((float(i) + 0.5) / float(n)) * vec2(cos(angle), sin(angle));
}

#ifdef SHADOWS
// Change of the map's depth over its width on the surface's plane: depths are compared on that plane.
vec2 depthSlope() {
  vec3 dx = dFdx(shadowCoord), dy = dFdy(shadowCoord);
  float area = dx.x * dy.y - dx.y * dy.x;
  vec2 slope = vec2(dy.y * dx.z - dx.y * dy.z, dx.x * dy.z - dy.x * dx.z) / (abs(area) > 1e-12 ? area : 1e-12);
  return slope * min(1.0, 4.0 / max(length(slope), 1e-6));
}

// Bilinear mix of four comparisons.
float litAt(vec3 coord) {
  vec4 lit = step(vec4(coord.z), textureGather(shadowMap, coord.xy));
  vec2 f = fract(coord.xy * frame.shadowVolume.z - 0.5);
  return mix(mix(lit.w, lit.z, f.x), mix(lit.x, lit.y, f.x), f.y);
}

// Fernando 2005, "Percentage-closer soft shadows", for a sun: the edge of a shadow is as wide as its distance from
// what casts it, times the sun's width.
float sunlight(float turn) {
  float width = frame.shadowVolume.x, depth = frame.shadowVolume.y, sun = frame.shadowVolume.w;
  float texel = 1.0 / frame.shadowVolume.z;
  vec2 slope = depthSlope();
  // what lies beyond the far end of the map is lit
  vec3 coord = vec3(shadowCoord.xy, min(shadowCoord.z, 1.0) - 1.5 * texel * (0.2 + length(slope)));
  float reach = sun * 0.35, sum = 0.0, count = 0.0;
  for (int i = 0; i < BLOCKER_TAPS; ++i) {
    // the middle first: rings alone would miss what is small and near
    vec2 offset = i == 0 ? vec2(0.0) : reach * onDisk(i, BLOCKER_TAPS, turn);
    float found = textureLod(shadowMap, coord.xy + offset, 0.0).r;
    float own = coord.z + dot(slope, offset);
    sum += found < own ? found : 0.0;
    count += found < own ? 1.0 : 0.0;
  }
  if (count == 0.0) {
    return 1.0;
  }
  float radius = clamp((coord.z - sum / count) * depth * sun / width, 1.2 * texel, reach);
  float lit = 0.0;
  for (int i = 0; i < PENUMBRA_TAPS; ++i) {
    vec2 offset = radius * onDisk(i, PENUMBRA_TAPS, turn);
    lit += litAt(coord + vec3(offset, dot(slope, offset)));
  }
  return lit / float(PENUMBRA_TAPS);
}

// Way of the sun's light inside the body, m.
float thickness(float turn) {
  float sum = 0.0;
  for (int i = 0; i < 8; ++i) {
    float found = textureLod(shadowMap, shadowCoord.xy + 0.02 * onDisk(i, 8, turn), 0.0).r;
    sum += max(shadowCoord.z - found, 0.0);
  }
  return sum / 8.0 * frame.shadowVolume.y;
}
#endif

// Burley 2012, "Physically based shading at Disney", and Hammon's approximation of Smith's masking (2017).
float specular(float nl, float nv, float nh, float roughness) {
  float a = roughness * roughness, a2 = a * a;
  float d = nh * nh * (a2 - 1.0) + 1.0;
  return a2 / (d * d) * nl / (2.0 * mix(2.0 * nl * nv, nl + nv, a) + 1e-4) * 0.5;
}

float fresnel(float cosine) {
  float m = clamp(1.0 - cosine, 0.0, 1.0), m2 = m * m;
  return m2 * m2 * m;
}

#ifndef GRID
// Warp and weft pass over each other; they fade out where a pixel is wider than a thread.
float weave(vec2 at) {
  vec2 t = material.w * at;
  float sharp = 1.0 - smoothstep(0.25, 0.7, max(fwidth(t.x), fwidth(t.y)));
  vec2 thread = abs(fract(t) - 0.5) * 2.0;
  float over = mod(floor(t.x) + floor(t.y), 2.0);
  float height = over > 0.5 ? 1.0 - thread.x * thread.x : 1.0 - thread.y * thread.y;
  return 1.0 - 0.3 * sharp * (1.0 - height);
}
#endif

// Light that other surfaces nearby of the same colour send back: Jimenez 2016, equation 11.
vec3 ambientShare(float open, vec3 albedo) {
  vec3 a = 2.0404 * albedo - 0.3324, b = -4.7951 * albedo + 0.6417, c = 2.7552 * albedo + 0.6903;
  return max(vec3(open), ((open * a + b) * open + c) * open);
}

void main() {
  vec3 normal = shadingNormal();
  vec3 light = frame.towardsLight.xyz, eye = normalize(toEye), middle = normalize(light + eye);
  float turn = 6.28318530718 * pixelNoise(gl_FragCoord.xy);
  float facing = dot(normal, light), nv = max(dot(normal, eye), 1e-3);
  vec3 albedo = surfaceColour();
#ifndef GRID
  if (material.w > 0.0) {
    albedo *= weave(uv);
  }
#endif
  float sun = 1.0, passed = 0.0;
#ifdef SHADOWS
#ifndef GRID
  if (material.z > 0.0) {
    passed = exp(-thickness(turn) / material.z);
  }
#endif
#ifdef TWO_SIDED
  sun = sunlight(turn);
#else
  sun = facing > 0.0 ? sunlight(turn) : 0.0;
#endif
#endif
#ifdef TWO_SIDED
  float lit = facing > 0.0 ? facing : material.w > 0.0 ? -0.3 * facing : 0.0;
#else
  float lit = max(facing, 0.0);
#endif
#if defined(SMOOTH) && !defined(TWO_SIDED)
  sun *= smoothstep(0.0, 0.2, facing);
#endif
  // the rays see the front of things only, and not beside the picture: make up for what they miss
  float open = pow(texelFetch(openness, ivec2(gl_FragCoord.xy), 0).r, 1.5);
  vec3 ambient = mix(frame.ground.rgb, frame.sky.rgb, 0.5 + 0.5 * normal.y) * ambientShare(open, albedo);
  // a weak lamp behind the scene lifts outlines from the dark
  vec3 back = normalize(vec3(-light.x, 0.4, -light.z));
  ambient += open * 0.16 * frame.sky.rgb * max(dot(normal, back), 0.0);
  float metal = material.y, rough = clamp(material.x, 0.05, 1.0);
  vec3 diffuse = albedo * (1.0 - metal) * (ambient + frame.sun.rgb * (sun * lit));
#ifndef GRID
  if (material.z > 0.0) {
    // Light scatters around edges, comes through from the other side, and has more of the jelly's colour then.
    float around = clamp((facing + 0.6) / 1.6, 0.0, 1.0);
    vec3 deep = albedo * (0.25 + 0.95 * albedo);
    diffuse = 0.45 * diffuse + deep * (0.6 * ambient +
                                       frame.sun.rgb * (0.35 * around * max(sun, passed) + 0.9 * passed));
  }
#endif
#ifdef GRID
  vec3 colour = diffuse;
  float far = length((frame.eye.xyz - toEye - frame.stage.xyz).xz) / frame.stage.w;
  colour *= mix(0.72, 1.0, exp(-0.12 * far * far));
  vec3 ray = -eye;
  colour = mix(colour, wallColour(ray), smoothstep(0.16, 0.02, -ray.y));
#else
  vec3 base = mix(vec3(0.04), albedo, metal);
  // a pixel at an outline shows a range of angles, not the most grazing one
  float grazing = fresnel(nv + 0.5 * min(fwidth(nv), 0.5));
  vec3 mirror = base + (max(vec3(1.0 - rough), base) - base) * grazing;
  vec3 shine = base + (1.0 - base) * fresnel(max(dot(middle, eye), 0.0));
  vec3 colour = diffuse + mirror * open * (1.0 - 0.7 * rough * (1.0 - metal)) *
                              surroundings(reflect(-eye, normal), rough);
  colour += frame.sun.rgb * sun * shine *
            min(specular(max(facing, 0.0), nv, max(dot(normal, middle), 0.0), rough), 12.0);
  if (material.w > 0.0) {
    colour += 0.25 * albedo * open * fresnel(0.6 * nv) * 2.0;
  }
#endif
  result = vec4(dithered(onFilm(colour)), 1.0);
}
