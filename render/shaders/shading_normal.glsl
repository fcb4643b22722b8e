in vec3 toEye;
#ifdef SMOOTH
centroid in vec3 smoothNormal;  // at an outline it would be extrapolated
#endif

// The triangle's normal, towards the viewer. It uses derivatives of toEye, not of the position, because its values
// stay small far from the origin.
vec3 faceNormal() {
  vec3 normal = cross(dFdx(toEye), dFdy(toEye));
  return normalize(dot(normal, toEye) < 0.0 ? -normal : normal);
}

// The normal that decides the colour.
vec3 shadingNormal() {
#ifdef SMOOTH
  vec3 normal = normalize(smoothNormal);
#ifdef TWO_SIDED
  normal = gl_FrontFacing ? normal : -normal;
#endif
  return normal;
#else
  return faceNormal();
#endif
}
