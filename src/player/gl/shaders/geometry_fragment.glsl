// Geometry pass: position, geometric and shading normal on the side that is seen, and albedo, as
// player/visible_surfaces.cpp has them.
in vec3 position;
in vec3 blended_normal;
in vec2 uv;

layout(binding = 0) uniform samplerBuffer triangle_normals;
layout(binding = 1) uniform sampler2D base_texture;
layout(location = 0) out vec4 position_out;  // w: 1 where there is a surface
layout(location = 1) out uvec4 surface_out;

uniform int first_triangle;
uniform vec4 base;  // colour and alpha
uniform float cutoff;
uniform vec3 eye;

void main() {
  vec4 colour = base;
#ifdef TEXTURED
  colour *= texture(base_texture, uv);
#endif
#ifdef MASKED
  if (colour.a < cutoff) discard;
#endif
  vec3 normal = texelFetch(triangle_normals, first_triangle + gl_PrimitiveID).xyz;
  bool front = dot(normal, position - eye) <= 0.0;
  normal = front ? normal : -normal;
  float size = length(blended_normal);
  vec3 shading_normal = (front ? 1.0 : -1.0) / max(size, 1e-3) * blended_normal;
  if (!(size > 1e-3) || !(dot(shading_normal, normal) > 0.0)) shading_normal = normal;
  position_out = vec4(position, 1.0);
  surface_out = pack_surface(normal, shading_normal, clamp(colour.rgb, 0.0, 1.0));
}
