// ClusterTransfer, left factor: one invocation per receiving sample.
layout(local_size_x = 64) in;

layout(binding = 0) uniform samplerBuffer reduced;       // quads
layout(binding = 1) uniform usamplerBuffer groups;       // sample begin, end, cluster
layout(binding = 2) uniform usamplerBuffer receivers;    // first quad, quads, reduced quad, samples' begin
layout(binding = 3) uniform MATRIX_BUFFER left;
layout(binding = 4) uniform samplerBuffer scales;
layout(std430, binding = 0) buffer Irradiance { vec4 irradiance[]; };

uniform int channel_quads;  // of the reduced vector

void main() {
  uvec4 group = texelFetch(groups, int(gl_WorkGroupID.x));
  int i = int(group.x + gl_LocalInvocationID.x);
  if (i >= int(group.y)) return;
  ivec4 receiver = ivec4(texelFetch(receivers, int(group.z)));
  int row = receiver.x + (i - receiver.w) * receiver.y;
  vec3 sum = vec3(0);
  for (int q = 0; q < receiver.y; ++q) {
    vec4 m = vec4(texelFetch(left, row + q));
    int r = receiver.z + q;
    sum += vec3(dot(m, texelFetch(reduced, r)), dot(m, texelFetch(reduced, channel_quads + r)),
                dot(m, texelFetch(reduced, 2 * channel_quads + r)));
  }
  irradiance[i] = vec4(texelFetch(scales, i).x * sum, 0.0);
}
