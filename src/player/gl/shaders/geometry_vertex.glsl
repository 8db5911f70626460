// The scene's triangles, from both sides.
layout(location = 0) in vec3 vertex_position;
layout(location = 1) in vec3 vertex_normal;
layout(location = 2) in vec2 vertex_uv;

uniform mat4 to_clip;

out vec3 position;
out vec3 blended_normal;
out vec2 uv;

void main() {
  position = vertex_position;
  blended_normal = vertex_normal;
  uv = vertex_uv;
  gl_Position = to_clip * vec4(vertex_position, 1.0);
}
