// ClusterProjection, first half: parts of each coefficient's sum over the samples of its cluster.
layout(local_size_x = 64) in;

layout(binding = 0) uniform samplerBuffer irradiance;
layout(binding = 1) uniform usamplerBuffer rows;  // first quad, quads, first sample, unused
layout(binding = 2) uniform MATRIX_BUFFER blocks;
layout(std430, binding = 0) buffer Partial { vec4 partial[]; };

uniform int count;  // rows × parts
uniform int parts;

void main() {
  int at = int(gl_GlobalInvocationID.x);
  if (at >= count) return;
  ivec4 row = ivec4(texelFetch(rows, at / parts));
  vec3 sum = vec3(0);
  for (int q = at % parts; q < row.y; q += parts) {
    vec4 m = vec4(texelFetch(blocks, row.x + q));
    int i = row.z + 4 * q;
    sum += m.x * texelFetch(irradiance, i).rgb + m.y * texelFetch(irradiance, i + 1).rgb +
           m.z * texelFetch(irradiance, i + 2).rgb + m.w * texelFetch(irradiance, i + 3).rgb;
  }
  partial[at] = vec4(sum, 0.0);
}
