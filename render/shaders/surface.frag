layout(binding = 1) uniform sampler2DShadow shadowMap;

layout(location = 0) out vec4 result;

#ifdef SHADOWS
// The bias is the change of depth of a plane with this slope across the filter's width. It prevents acne at every
// angle and is small where the light is perpendicular, so that contacts stay dark.
float sunlight(float facing) {
  float tangent = min(sqrt(max(1.0 - facing * facing, 0.0)) / max(facing, 0.05), 12.0);
  vec3 coord = vec3(shadowCoord.xy, shadowCoord.z - frame.towardsLight.w * (0.5 + tangent));
#if SHADOW_TAPS == 4
  vec2 step = 0.75 / vec2(textureSize(shadowMap, 0));
  return 0.25 * (texture(shadowMap, coord + vec3(-step.x, -step.y, 0.0)) +
                 texture(shadowMap, coord + vec3(step.x, -step.y, 0.0)) +
                 texture(shadowMap, coord + vec3(-step.x, step.y, 0.0)) +
                 texture(shadowMap, coord + vec3(step.x, step.y, 0.0)));
#else
  return texture(shadowMap, coord);
#endif
}
#endif

// cos^48 by multiplication: pow() costs several times as much on a software rasteriser.
float highlight(float cosine) {
  float c2 = cosine * cosine;
  float c4 = c2 * c2;
  float c8 = c4 * c4;
  float c16 = c8 * c8;
  return c16 * c16 * c16;
}

void main() {
  vec3 normal = shadingNormal();
#ifdef SMOOTH
  vec3 face = faceNormal();
#else
  vec3 face = normal;
#endif
  vec3 light = frame.towardsLight.xyz;
  float facing = dot(normal, light);
#ifdef TWO_SIDED
  // Thin cloth transmits some light to the side that faces away from the sun.
  float lit = facing > 0.0 ? facing : -0.3 * facing;
  float sun = 1.0;
#else
  float lit = max(facing, 0.0);
  float sun = lit > 0.0 ? 1.0 : 0.0;
#endif
#ifdef SHADOWS
  if (sun > 0.0) {
    sun = sunlight(abs(dot(face, light)));
  }
#endif
#if defined(SMOOTH) && !defined(TWO_SIDED)
  // A triangle that faces away from the light is in its own shadow, even if its smooth normal faces the light. The sun
  // fades out before that, which hides the triangle's edge.
  sun *= smoothstep(0.0, 0.25, facing);
#endif
  vec3 middle = normalize(light + normalize(toEye));
  vec3 ambient = mix(frame.ground.rgb, frame.sky.rgb, 0.5 + 0.5 * normal.y);
  vec3 colour = surfaceColour() * (ambient + frame.sun.rgb * (sun * lit));
#ifdef GRID
  colour = mix(colour, dithered(backgroundColour()), smoothstep(0.35, 1.0, length(uv) / shapeRadius));
#else
  float shine = facing > 0.0 ? highlight(max(dot(normal, middle), 0.0)) : 0.0;
  colour += frame.sun.rgb * (0.22 * sun * shine);
#endif
  result = vec4(colour, 1.0);
}
