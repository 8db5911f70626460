// ClusterProjection, second half: sums up the parts. Coefficients stand channel by channel, each
// cluster's padded to whole quads.
layout(local_size_x = 64) in;

layout(binding = 0) uniform samplerBuffer partial;
layout(binding = 1) uniform samplerBuffer scales;
layout(binding = 2) uniform usamplerBuffer places;
layout(std430, binding = 0) buffer Coefficients { float coefficients[]; };

uniform int count;
uniform int parts;
uniform int padded;  // coefficients of a channel

void main() {
  int row = int(gl_GlobalInvocationID.x);
  if (row >= count) return;
  vec3 sum = vec3(0);
  for (int k = 0; k < parts; ++k) sum += texelFetch(partial, row * parts + k).rgb;
  sum *= texelFetch(scales, row).x;
  int place = int(texelFetch(places, row).x);
  coefficients[place] = sum.r;
  coefficients[padded + place] = sum.g;
  coefficients[2 * padded + place] = sum.b;
}
