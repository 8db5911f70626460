// What near senders send back, times pi: albedo times their irradiance.
layout(local_size_x = 64) in;

layout(binding = 0) uniform samplerBuffer direct;
layout(binding = 1) uniform samplerBuffer other;
layout(binding = 2) uniform samplerBuffer albedo;
layout(std430, binding = 0) buffer Exitant { vec4 exitant[]; };

uniform float direct_share;
uniform float other_share;
uniform int count;

void main() {
  int i = int(gl_GlobalInvocationID.x);
  if (i >= count) return;
  vec3 irradiance = direct_share * texelFetch(direct, i).rgb + other_share * texelFetch(other, i).rgb;
  exitant[i] = vec4(texelFetch(albedo, i).rgb * irradiance, 0.0);
}
