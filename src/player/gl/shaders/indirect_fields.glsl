// Puts light that pixels take from the samples as it is, indirect and the environment's, beside the
// visibilities that the light step has written: all that a pixel reads of a sample stands together.
layout(local_size_x = 64) in;

layout(binding = 0) uniform samplerBuffer indirect;
layout(std430, binding = 1) buffer Fields { float fields[]; };
layout(binding = 2) uniform samplerBuffer sky;

uniform int count;
uniform int field_stride;
uniform float indirect_share;  // 0: there is none, or it is not shown
uniform float sky_share;

void main() {
  int i = int(gl_GlobalInvocationID.x);
  if (i >= count) return;
  vec3 value = indirect_share * texelFetch(indirect, i).rgb + sky_share * texelFetch(sky, i).rgb;
  fields[i * field_stride] = value.r;
  fields[i * field_stride + 1] = value.g;
  fields[i * field_stride + 2] = value.b;
}
