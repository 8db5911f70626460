// The picture of an environment, as scene/environment.cpp looks it up: equirectangular, row 0 next to
// straight up.
layout(binding = 10) uniform sampler2D environment_image;

uniform float turn;        // radians about +Y
uniform float reflection;  // share that surfaces mirror
uniform vec3 view_right;   // the camera's axes, scaled so that a pixel's place in the picture, from
uniform vec3 view_up;      // -1 to 1 either way, times the first two less the third is its view
uniform vec3 view_back;
uniform vec2 picture_size;

vec3 environment_at(vec3 direction) {
  const float pi = 3.14159265;
  ivec2 size = textureSize(environment_image, 0);
  float across = (atan(direction.x, -direction.z) + turn) / (2.0 * pi) + 0.5;
  across -= floor(across);
  float down = acos(clamp(direction.y, -1.0, 1.0)) / pi;
  ivec2 cell = ivec2(vec2(across, down) * vec2(size));
  return texelFetch(environment_image, clamp(cell, ivec2(0), size - 1), 0).rgb;
}

vec3 view_direction() {
  vec2 place = 2.0 * gl_FragCoord.xy / picture_size - 1.0;
  return normalize(place.x * view_right + place.y * view_up - view_back);
}
