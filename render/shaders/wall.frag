layout(location = 0) out vec4 result;

void main() { result = vec4(dithered(onFilm(wallColour(normalize(viewRay(gl_FragCoord.xy))))), 1.0); }
