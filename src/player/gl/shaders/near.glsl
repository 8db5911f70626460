// NearTransfer: each receiver gathers from its own senders. Receivers of like length stand next to
// each other, so that none waits for its neighbours.
layout(local_size_x = 64) in;

layout(binding = 0) uniform samplerBuffer exitant;
layout(binding = 1) uniform usamplerBuffer receivers;  // receiver, begin, end
layout(binding = 2) uniform usamplerBuffer senders;    // sender, share in 1/65535
layout(std430, binding = 0) buffer Received { vec4 received[]; };

uniform int count;

void main() {
  if (int(gl_GlobalInvocationID.x) >= count) return;
  uvec4 receiver = texelFetch(receivers, int(gl_GlobalInvocationID.x));
  vec3 sum = vec3(0);
  for (int k = int(receiver.y); k < int(receiver.z); ++k) {
    uvec2 sender = texelFetch(senders, k).xy;
    sum += float(sender.y) * texelFetch(exitant, int(sender.x)).rgb;
  }
  received[receiver.x] = vec4(sum / 65535.0, 0.0);
}
