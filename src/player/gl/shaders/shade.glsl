// Light and colour of a pixel, as Evaluator::reconstruct and player/picture.cpp have them: indirect
// light, and the environment's, interpolated from the samples; direct light by the pixel's own
// distance and cosine times interpolated visibility; what is mirrored of the environment; tone
// mapped. LIGHTS is the number of lights, QUADS that of a sample's fields; with ENVIRONMENT there
// is a picture of one (environment.glsl).
layout(binding = 2) uniform sampler2D position_image;
layout(binding = 3) uniform usampler2D surface_image;
layout(binding = 4) uniform usampler2D splats_0;
layout(binding = 5) uniform usampler2D splats_1;
layout(binding = 6) uniform usampler2D splats_2;
layout(binding = 7) uniform samplerBuffer fields;
layout(binding = 8) uniform samplerBuffer normals;
layout(binding = 9) uniform samplerBuffer cluster_colours;
layout(location = 0) out vec4 colour_out;

uniform float direct_share;
uniform float exposure;
uniform vec3 background;
uniform vec3 unlit_colour;
uniform vec3 eye;

vec4 sums[QUADS];     // of weight × field
vec4 weights[QUADS];  // of the samples that the light shines on
vec3 indirect = vec3(0);
float total = 0.0;

void add_sample(uint entry) {
  int index = int(entry & 0x3FFFFFu);
  float weight = float(entry >> 22);
  total += weight;
  for (int q = 0; q < QUADS; ++q) {
    vec4 field = texelFetch(fields, index * QUADS + q);
    if (q == 0) indirect += weight * field.rgb;
    vec4 lit = weight * step(vec4(0), field);
    sums[q] += lit * field;
    weights[q] += lit;
  }
}

void add_samples(uvec4 entries) {
  add_sample(entries.x);
  add_sample(entries.y);
  add_sample(entries.z);
  add_sample(entries.w);
}

void gather(ivec2 pixel) {
  for (int q = 0; q < QUADS; ++q) {
    sums[q] = vec4(0);
    weights[q] = vec4(0);
  }
  uvec4 entries = texelFetch(splats_0, pixel, 0);
  add_samples(entries);
  for (bool more = entries.w != 0u; more; more = false) {
    entries = texelFetch(splats_1, pixel, 0);
    add_samples(entries);
    for (bool yet = entries.w != 0u; yet; yet = false) add_samples(texelFetch(splats_2, pixel, 0));
  }
  indirect = total > 0.0 ? indirect / total : vec3(0);
}

// -1 where no sample near is lit.
float visibility_of(int light) {
  int field = 3 + light;
  float weight = weights[field / 4][field % 4];
  return weight > 0.0 ? sums[field / 4][field % 4] / weight : -1.0;
}

vec3 unshadowed(int index, vec3 p, vec3 n) {
  Light light = light_at(index);
  vec3 sum = vec3(0);
  for (int k = 0; k < light.points; ++k) {
    Incident incident = incident_light(light, p, light_point(light, k));
    sum += max(0.0, dot(n, incident.to_light)) * incident.irradiance;
  }
  return sum / float(light.points);
}

// Narkowicz (2015), as player/tone.cpp.
vec3 filmic(vec3 exposed) {
  vec3 x = clamp(exposed, 0.0, 1e4);
  return clamp((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
}

vec3 radiance(vec3 p, uvec4 surface) {
  vec3 direct = vec3(0);
  vec3 normal = surface_shading_normal(surface);
#if LIGHTS > 0
  for (int light = 0; light < LIGHTS; ++light) {
    direct += max(0.0, visibility_of(light)) * unshadowed(light, p, normal);
  }
#endif
  vec3 irradiance = direct_share * direct + indirect;
  vec3 colour = max(vec3(0), surface_albedo(surface) * irradiance) / kPi;
#ifdef ENVIRONMENT
  for (bool mirrors = reflection > 0.0; mirrors; mirrors = false) {
    colour += reflection * environment_at(reflect(normalize(p - eye), normal));
  }
#endif
  return colour;
}

vec3 cluster_colour(ivec2 pixel, vec3 p, vec3 normal) {
  uint heaviest = 0u;
  for (int q = 0; q < 3; ++q) {
    uvec4 e = q == 0 ? texelFetch(splats_0, pixel, 0)
                     : q == 1 ? texelFetch(splats_1, pixel, 0) : texelFetch(splats_2, pixel, 0);
    heaviest = max(heaviest, max(max(e.x, e.y), max(e.z, e.w)));
  }
  int cluster = int(texelFetch(normals, int(heaviest & 0x3FFFFFu)).w);
  float facing = abs(dot(normal, normalize(eye - p)));
  vec3 colour = (0.4 + 0.6 * facing) * texelFetch(cluster_colours, cluster).rgb;
  return heaviest != 0u ? colour : vec3(0);
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 position = texelFetch(position_image, pixel, 0);
  uvec4 surface = texelFetch(surface_image, pixel, 0);
#ifdef SHOW_CLUSTERS
  vec3 colour = cluster_colour(pixel, position.xyz, surface_shading_normal(surface));
#else
  gather(pixel);
#ifdef SHOW_VISIBILITY
  float share = LIGHTS > 0 ? visibility_of(0) : -1.0;
  vec3 colour = share < 0.0 ? unlit_colour : vec3(share);
#else
  vec3 colour = radiance(position.xyz, surface);
#ifndef RADIANCE
  colour = filmic(exposure * colour);
#endif
#endif
#endif
  vec3 behind = background;
#ifdef ENVIRONMENT
  for (bool open = position.w <= 0.0; open; open = false) {
    behind = environment_at(view_direction());
#ifndef RADIANCE
    behind = filmic(exposure * behind);
#endif
  }
#endif
  colour_out = position.w > 0.0 ? vec4(colour, 1.0) : vec4(behind, 0.0);
}
