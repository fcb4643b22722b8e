// Ottosson 2020, "A perceptual color space for image processing".
vec3 oklabToLinear(vec3 lab) {
  vec3 root = vec3(dot(lab, vec3(1.0, 0.3963377774, 0.2158037573)),
                   dot(lab, vec3(1.0, -0.1055613458, -0.0638541728)),
                   dot(lab, vec3(1.0, -0.0894841775, -1.2914855480)));
  vec3 lms = root * root * root;
  return vec3(dot(lms, vec3(4.0767416621, -3.3077115913, 0.2309699292)),
              dot(lms, vec3(-1.2684380046, 2.6097574011, -0.3413193965)),
              dot(lms, vec3(-0.0041960863, -0.7034186147, 1.7076147010)));
}
