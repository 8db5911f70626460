// Weighted sum of two values at the samples.
layout(local_size_x = 64) in;

layout(binding = 0) uniform samplerBuffer a;
layout(binding = 1) uniform samplerBuffer b;
layout(std430, binding = 0) buffer Sum { vec4 sum[]; };

uniform float a_share;
uniform float b_share;
uniform int count;

void main() {
  int i = int(gl_GlobalInvocationID.x);
  if (i < count) sum[i] = a_share * texelFetch(a, i) + b_share * texelFetch(b, i);
}
