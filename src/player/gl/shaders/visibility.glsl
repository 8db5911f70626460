// Direct light at the samples of one light: depth buffers reconstructed for the four directions
// next to each light sample (Leonhardt & Bohn, §5), or the walls of a convex space. Mirrors
// player/depth_tables.cpp and the light step of player/evaluator.cpp.
layout(local_size_x = 64) in;

#ifdef FLOAT_COEFFICIENTS
#define COEFFICIENT_BUFFER samplerBuffer
#else
#define COEFFICIENT_BUFFER isamplerBuffer
#endif
#ifdef FLOAT_BASIS
#define BASIS_BUFFER samplerBuffer
#else
#define BASIS_BUFFER isamplerBuffer
#endif

layout(binding = 2) uniform samplerBuffer positions;
layout(binding = 3) uniform samplerBuffer normals;
layout(binding = 4) uniform samplerBuffer tangents;
layout(binding = 5) uniform usamplerBuffer groups;    // sample begin, end, cluster
layout(binding = 6) uniform usamplerBuffer clusters;  // two texels: Cluster
layout(binding = 7) uniform COEFFICIENT_BUFFER coefficients;  // samples × quads of functions
layout(binding = 8) uniform samplerBuffer coefficient_scales;
layout(binding = 9) uniform BASIS_BUFFER basis;          // directions × quads of functions
layout(binding = 10) uniform samplerBuffer basis_scales;  // quads of functions
layout(binding = 11) uniform samplerBuffer means;         // directions
layout(binding = 12) uniform samplerBuffer walls;
layout(std430, binding = 0) buffer Irradiance { vec4 irradiance[]; };
layout(std430, binding = 1) buffer Fields { float fields[]; };

uniform int light_index;
uniform int field;         // of the light's visibility
uniform int field_stride;  // floats of a sample's fields
layout(location = 0) uniform ivec2 grid;  // directions: width × height
uniform float bound;
uniform float bias;
uniform float wall_slack;  // m
uniform float unlit;
uniform bool shadows;
uniform bool first_light;

struct Cluster {
  int sample_begin, coefficient_begin, basis_begin, quads;
  int scale_begin, mean_begin, wall_begin, wall_count;
};

Cluster cluster_at(int c) {
  ivec4 a = ivec4(texelFetch(clusters, 2 * c));
  ivec4 b = ivec4(texelFetch(clusters, 2 * c + 1));
  return Cluster(a.x, a.y, a.z, a.w, b.x, b.y, b.z, b.w);
}

// The concentric map backwards (domains/directions.cpp).
vec2 disk_to_square(vec2 d) {
  float r = length(d);
  vec2 a = abs(d);
  float angle = r > 0.0 ? atan(min(a.x, a.y), max(a.x, a.y)) : 0.0;
  float minor = r * angle * (4.0 / kPi);
  vec2 square = a.x >= a.y ? vec2(r, minor) : vec2(minor, r);
  return vec2(d.x < 0.0 ? -square.x : square.x, d.y < 0.0 ? -square.y : square.y);
}

struct Lookup {
  ivec4 direction;
  vec4 weight;
};

Lookup lookup(vec3 local) {
  float r2 = clamp(1.0 - local.z, 0.0, 1.0);
  vec2 square = disk_to_square(local.xy * inversesqrt(max(1e-12, 2.0 - r2)));
  vec2 at = clamp((square + 1.0) * 0.5 * vec2(grid) - 0.5, vec2(0), vec2(grid - 1));
  ivec2 low = min(ivec2(at), max(ivec2(0), grid - 2));
  ivec2 high = min(low + 1, grid - 1);
  vec2 w = at - vec2(low);
  return Lookup(ivec4(low.y, low.y, high.y, high.y) * grid.x + ivec4(low.x, high.x, low.x, high.x),
                vec4((1.0 - w.x) * (1.0 - w.y), w.x * (1.0 - w.y), (1.0 - w.x) * w.y, w.x * w.y));
}

// Encoded depths of four directions: mean + coefficients · basis.
vec4 depths(Cluster cluster, int place, ivec4 direction) {
  int row = cluster.coefficient_begin + place * cluster.quads;
  ivec4 column = cluster.basis_begin + direction * cluster.quads;
  vec4 sum = vec4(0);
  for (int q = 0; q < cluster.quads; ++q) {
    vec4 c = vec4(texelFetch(coefficients, row + q)) *
             texelFetch(basis_scales, cluster.scale_begin + q);
    sum += vec4(dot(c, vec4(texelFetch(basis, column.x + q))),
                dot(c, vec4(texelFetch(basis, column.y + q))),
                dot(c, vec4(texelFetch(basis, column.z + q))),
                dot(c, vec4(texelFetch(basis, column.w + q))));
  }
  ivec4 mean = cluster.mean_begin + direction;
  float scale = texelFetch(coefficient_scales, cluster.sample_begin + place).x;
  return scale * sum + vec4(texelFetch(means, mean.x).x, texelFetch(means, mean.y).x,
                            texelFetch(means, mean.z).x, texelFetch(means, mean.w).x);
}

float through_walls(Cluster cluster, vec3 inside, vec3 to_light, float distance) {
  float open = 1.0;
  for (int w = 0; w < cluster.wall_count; ++w) {
    vec4 wall = texelFetch(walls, cluster.wall_begin + w);
    float beyond = dot(wall.xyz, inside) - wall.w + distance * dot(wall.xyz, to_light);
    if (beyond > wall_slack) open = 0.0;
  }
  return open;
}

float visible_share(Cluster cluster, int i, vec3 p, mat3 frame, Incident incident) {
  vec3 local = incident.to_light * frame;
  Lookup four = lookup(local);
  float threshold = sqrt(min(incident.distance, bound) * (1.0 - bias) / bound);
  vec4 depth = depths(cluster, i - cluster.sample_begin, four.direction);
  float share = dot(four.weight, vec4(greaterThanEqual(depth, vec4(threshold))));
  if (cluster.mean_begin < 0) {
    share = through_walls(cluster, p, incident.to_light, incident.distance);
  }
  return local.z > 0.0 ? share : 0.0;
}

void main() {
  uvec4 group = texelFetch(groups, int(gl_WorkGroupID.x));
  int i = int(group.x + gl_LocalInvocationID.x);
  if (i >= int(group.y)) return;
  Cluster cluster = cluster_at(int(group.z));
  Light light = light_at(light_index);
  vec3 p = texelFetch(positions, i).xyz;
  vec3 normal = texelFetch(normals, i).xyz;
  vec3 tangent = texelFetch(tangents, i).xyz;
  mat3 frame = mat3(tangent, cross(normal, tangent), normal);
  vec3 arrived = vec3(0);
  float power = 0.0;
  float seen = 0.0;
  for (int k = 0; k < light.points; ++k) {
    Incident incident = incident_light(light, p, light_point(light, k));
    float cosine = dot(normal, incident.to_light);
    if (!(cosine > 0.0)) continue;
    vec3 unshadowed = cosine * incident.irradiance;
    float share = shadows ? visible_share(cluster, i, p, frame, incident) : 1.0;
    arrived += share * unshadowed;
    float weight = unshadowed.x + unshadowed.y + unshadowed.z;
    power += weight;
    seen += share * weight;
  }
  bool lit = power > 0.0;
  vec3 before = first_light ? vec3(0) : irradiance[i].xyz;
  irradiance[i] = vec4(before + (lit ? arrived / float(light.points) : vec3(0)), 0.0);
  fields[i * field_stride + field] = lit ? seen / power : unlit;
}
