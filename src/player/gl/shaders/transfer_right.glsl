// ClusterTransfer, right factor: one invocation per row and channel.
layout(local_size_x = 64) in;

layout(binding = 0) uniform samplerBuffer coefficients;  // quads
layout(binding = 1) uniform usamplerBuffer rows;  // first quad, quads of a channel, columns, place
layout(binding = 2) uniform usamplerBuffer columns;  // quad of coefficients for a quad of the row
layout(binding = 3) uniform MATRIX_BUFFER right;
layout(binding = 4) uniform samplerBuffer scales;
layout(std430, binding = 0) buffer Reduced { float reduced[]; };

uniform int count;        // rows × 3
uniform int coloured;     // 1: each channel has columns of its own, else 0
uniform int channel_quads;  // quads of a channel's coefficients
uniform int padded;       // rows of a channel

void main() {
  int at = int(gl_GlobalInvocationID.x);
  if (at >= count) return;
  int channel = at % 3;
  ivec4 row = ivec4(texelFetch(rows, at / 3));
  int matrix = row.x + coloured * channel * row.y;
  int sent = channel * channel_quads;
  float sum = 0.0;
  for (int q = 0; q < row.y; ++q) {
    int column = int(texelFetch(columns, row.z + q).x);
    sum += dot(vec4(texelFetch(right, matrix + q)), texelFetch(coefficients, sent + column));
  }
  reduced[channel * padded + row.w] = texelFetch(scales, at / 3).x * sum;
}
