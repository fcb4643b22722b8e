// The gallery's surroundings: a wall that meets the floor in a curve, a lamp above, and the curve of film.

// View ray through a pixel, 1 m deep.
vec3 viewRay(vec2 pixel) {
  vec2 at = 2.0 * pixel / frame.viewport.xy - 1.0;
  return frame.forward.xyz + at.x * frame.right.xyz + at.y * frame.down.xyz;
}

vec3 wallColour(vec3 direction) {
  return mix(frame.backgroundBottom.rgb, frame.backgroundTop.rgb, smoothstep(-0.02, 0.55, direction.y));
}

// What a surface reflects from a direction; a rough one averages over more of it.
vec3 surroundings(vec3 direction, float roughness) {
  float blur = 0.1 + 0.7 * roughness;
  vec3 below = 0.55 * frame.backgroundBottom.rgb;
  vec3 colour = mix(below, wallColour(direction), smoothstep(-blur, blur, direction.y));
  vec3 lamp = normalize(frame.towardsLight.xyz + vec3(0.0, 0.6, 0.0));
  float edge = 0.06 + 0.4 * roughness;
  float share = smoothstep(0.90 - edge, 0.90 + edge, dot(direction, lamp));
  return colour + frame.sun.rgb * (1.6 - 1.3 * roughness) * share;
}

// Narkowicz 2015, "ACES filmic tone mapping curve", with the exposure that keeps middle grey.
vec3 onFilm(vec3 light) {
  vec3 x = 0.68 * light;
  return clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
}
