// What a pixel knows of the surface that it sees: packed by the geometry pass, read by the others.
vec2 to_octahedron(vec3 n) {
  vec2 p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
  vec2 folded = (1.0 - abs(p.yx)) * vec2(p.x >= 0.0 ? 1.0 : -1.0, p.y >= 0.0 ? 1.0 : -1.0);
  return n.z >= 0.0 ? p : folded;
}

vec3 from_octahedron(vec2 p) {
  vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
  float fold = max(-n.z, 0.0);
  n.x += n.x >= 0.0 ? -fold : fold;
  n.y += n.y >= 0.0 ? -fold : fold;
  return normalize(n);
}

uvec4 pack_surface(vec3 normal, vec3 shading_normal, vec3 albedo) {
  return uvec4(packSnorm2x16(to_octahedron(normal)), packSnorm2x16(to_octahedron(shading_normal)),
               packHalf2x16(albedo.rg), packHalf2x16(vec2(albedo.b, 0.0)));
}

vec3 surface_normal(uvec4 surface) { return from_octahedron(unpackSnorm2x16(surface.x)); }
vec3 surface_shading_normal(uvec4 surface) { return from_octahedron(unpackSnorm2x16(surface.y)); }
vec3 surface_albedo(uvec4 surface) {
  return vec3(unpackHalf2x16(surface.z), unpackHalf2x16(surface.w).x);
}
