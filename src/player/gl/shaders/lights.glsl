// Light that reaches a point, unshadowed, as scene/light.cpp has it. Only the kinds of light that
// are played are compiled (LIGHT_POINT and so on): software renderers run every branch.
const float kPi = 3.14159265358979323846;
const float kInfinity = 1.0 / 0.0;

layout(binding = 0) uniform samplerBuffer light_table;   // six texels a light
layout(binding = 1) uniform samplerBuffer light_points;  // (u, v) of the lights' samples

struct Light {
  vec3 position;
  int kind;
  vec3 direction;
  float radius;
  vec3 intensity;
  float inner_cosine;
  vec3 edge_u;
  float outer_cosine;
  vec3 edge_v;
  int first_point;
  int points;
};

struct Incident {
  vec3 to_light;
  float distance;
  vec3 irradiance;  // on a plane that faces the light
};

Light light_at(int i) {
  vec4 a = texelFetch(light_table, 6 * i);
  vec4 b = texelFetch(light_table, 6 * i + 1);
  vec4 c = texelFetch(light_table, 6 * i + 2);
  vec4 d = texelFetch(light_table, 6 * i + 3);
  vec4 e = texelFetch(light_table, 6 * i + 4);
  vec4 f = texelFetch(light_table, 6 * i + 5);
  return Light(a.xyz, int(a.w), b.xyz, b.w, c.xyz, c.w, d.xyz, d.w, e.xyz, int(f.x), int(f.y));
}

Incident from_point(vec3 position, vec3 intensity, vec3 p) {
  vec3 offset = position - p;
  float squared = dot(offset, offset);
  if (!(squared > 0.0)) return Incident(vec3(0, 1, 0), 0.0, vec3(0));
  float inverse = inversesqrt(squared);
  return Incident(offset * inverse, squared * inverse, intensity / squared);
}

Incident from_spot(Light light, vec3 p) {
  Incident incident = from_point(light.position, light.intensity, p);
  float cosine = -dot(light.direction, incident.to_light);
  float width = max(0.001, light.inner_cosine - light.outer_cosine);
  float falloff = clamp((cosine - light.outer_cosine) / width, 0.0, 1.0);
  incident.irradiance *= falloff * falloff;
  return incident;
}

mat3 frame_from_normal(vec3 n) {
  float s = n.z < 0.0 ? -1.0 : 1.0;
  float a = -1.0 / (s + n.z);
  float b = n.x * n.y * a;
  return mat3(vec3(1.0 + s * n.x * n.x * a, s * b, -s * n.x), vec3(b, s + n.y * n.y * a, -n.y), n);
}

Incident from_inside_sphere(Light light, vec3 offset, float distance, vec2 uv, vec3 radiance) {
  float z = 1.0 - 2.0 * uv.x;
  float ring = sqrt(max(0.0, 1.0 - z * z));
  vec3 direction = vec3(ring * cos(2.0 * kPi * uv.y), ring * sin(2.0 * kPi * uv.y), z);
  float along = dot(offset, direction);
  float off_axis2 = max(0.0, distance * distance - along * along);
  float half_chord = sqrt(max(0.0, light.radius * light.radius - off_axis2));
  return Incident(direction, along + half_chord, radiance * (4.0 * kPi));
}

Incident from_sphere(Light light, vec3 p, vec2 uv) {
  vec3 radiance = light.intensity / (kPi * light.radius * light.radius);
  vec3 offset = light.position - p;
  float distance = length(offset);
  if (distance <= light.radius) return from_inside_sphere(light, offset, distance, uv, radiance);
  float sine2_max = (light.radius / distance) * (light.radius / distance);
  float cosine_max = sqrt(max(0.0, 1.0 - sine2_max));
  float one_minus_cosine_max = sine2_max / (1.0 + cosine_max);
  float one_minus_cosine = uv.x * one_minus_cosine_max;
  float cosine = 1.0 - one_minus_cosine;
  float sine2 = one_minus_cosine * (1.0 + cosine);
  float sine = sqrt(sine2);
  float angle = 2.0 * kPi * uv.y;
  vec3 local = vec3(sine * cos(angle), sine * sin(angle), cosine);
  vec3 direction = normalize(frame_from_normal(offset / distance) * local);
  float half_chord2 = light.radius * light.radius - distance * distance * sine2;
  float to_surface = distance * cosine - sqrt(max(0.0, half_chord2));
  return Incident(direction, to_surface, radiance * (2.0 * kPi * one_minus_cosine_max));
}

Incident from_quad(Light light, vec3 p, vec2 uv) {
  vec3 point = light.position + (uv.x - 0.5) * light.edge_u + (uv.y - 0.5) * light.edge_v;
  Incident incident = from_point(point, light.intensity, p);
  vec3 area_vector = cross(light.edge_u, light.edge_v);
  incident.irradiance *= max(0.0, -dot(area_vector, incident.to_light));
  return incident;
}

Incident incident_light(Light light, vec3 p, vec2 uv) {
  Incident incident = Incident(vec3(0, 1, 0), 0.0, vec3(0));
#ifdef LIGHT_POINT
  if (light.kind == 0) incident = from_point(light.position, light.intensity, p);
#endif
#ifdef LIGHT_SPHERE
  if (light.kind == 1) incident = from_sphere(light, p, uv);
#endif
#ifdef LIGHT_SPOT
  if (light.kind == 2) incident = from_spot(light, p);
#endif
#ifdef LIGHT_QUAD
  if (light.kind == 3) incident = from_quad(light, p, uv);
#endif
#ifdef LIGHT_SUN
  if (light.kind == 4) incident = Incident(-light.direction, kInfinity, light.intensity);
#endif
  return incident;
}

vec2 light_point(Light light, int i) { return texelFetch(light_points, light.first_point + i).xy; }
