layout(std430, binding = 1) NORMALS_ACCESS buffer Normals { float normals[]; };
