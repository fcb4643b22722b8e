// Data of the frame and of the draw call for all stages; equal to FrameUniforms in C++.
layout(std140, binding = 0) uniform Frame {
  mat4 viewProjection;
  mat4 worldToShadow;    // To shadow map coordinates in x and y, depth in z.
  vec4 eye;
  vec4 towardsLight;     // Unit vector; w: shadow bias in depth per unit of tangent.
  vec4 sun;
  vec4 sky;
  vec4 ground;
  vec4 backgroundTop;    // Linear, as all colours here.
  vec4 backgroundBottom;
  vec4 viewport;         // Width, height; line width in pixels; one over the strain range.
  // Of the gallery's look.
  vec4 forward;          // View ray of the picture's middle, 1 m deep.
  vec4 right;            // From there to the right edge. The place at a depth d is right.w / (d + forward.w) rays away.
  vec4 down;             // From there to the lower edge; w: reach of ambient occlusion, m.
  vec4 shadowVolume;     // Width and depth of the shadow map's volume, m; texels per side; tangent of the sun's radius.
  vec4 stage;            // Middle of what is shown; w: its radius, m.
} frame;

// "Points" is the bound buffer. For a shape with a skin these are its places, except in the shaders that draw lines
// or compute the skin.
uniform uint firstPoint;     // Of the first instance, in Points.
uniform uint firstInstance;  // In Instances.
uniform uint pointCount;     // Per instance.
uniform uint firstNormal;    // Of the first instance, in Normals.
uniform uint normalCount;    // Per instance: #points, or more if edges are sharp.
uniform float shapeRadius;   // Of the tube, or at which the grid has faded out.
