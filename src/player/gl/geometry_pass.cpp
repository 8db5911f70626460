#include "player/gl/geometry_pass.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "player/view.h"

namespace prt::gl {
namespace {

/// Nearest visible depth as a share of the scene's diagonal. With depth running from 1 at the eye
/// to 0 far off, floats resolve all of it (Lapidous & Jiao 1999); without GL_ARB_clip_control they
/// need a larger share.
constexpr float kNearShare = 1e-5F;
constexpr float kNearShareForward = 1e-4F;

template <typename T>
Name upload(GLenum target, const std::vector<T>& values) {
  Name buffer = new_buffer();
  glBindBuffer(target, buffer.id());
  glBufferData(target, static_cast<GLsizeiptr>(values.size() * sizeof(T)), values.data(),
               GL_STATIC_DRAW);
  return buffer;
}

void attribute(GLuint index, GLint size) {
  glEnableVertexAttribArray(index);
  glVertexAttribPointer(index, size, GL_FLOAT, GL_FALSE, 0, nullptr);
}

GLint wrap(Texture::Wrap wrap) {
  if (wrap == Texture::Wrap::kClamp) return GL_CLAMP_TO_EDGE;
  return wrap == Texture::Wrap::kMirror ? GL_MIRRORED_REPEAT : GL_REPEAT;
}

Name upload(const Texture& texture) {
  Name image = new_texture();
  glBindTexture(GL_TEXTURE_2D, image.id());
  glTexImage2D(GL_TEXTURE_2D, 0, GL_SRGB8_ALPHA8, texture.width, texture.height, 0, GL_RGBA,
               GL_UNSIGNED_BYTE, texture.rgba.data());
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, wrap(texture.wrap_u));
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, wrap(texture.wrap_v));
  return image;
}

}  // namespace

GeometryPass::GeometryPass(const Scene& scene)
    : reversed_depth_(epoxy_gl_version() >= 45 || epoxy_has_gl_extension("GL_ARB_clip_control")) {
  near_ = (reversed_depth_ ? kNearShare : kNearShareForward) * std::max(scene.diagonal(), 1e-20F);
  upload_vertices(scene);
  upload_triangles(scene);
  for (const Texture& texture : scene.textures) textures_.push_back(upload(texture));
}

void GeometryPass::upload_vertices(const Scene& scene) {
  vertices_ = new_vertex_array();
  glBindVertexArray(vertices_.id());
  positions_ = upload(GL_ARRAY_BUFFER, scene.positions);
  attribute(0, 3);
  normals_ = upload(GL_ARRAY_BUFFER, scene.normals);
  attribute(1, 3);
  uvs_ = upload(GL_ARRAY_BUFFER, scene.uvs);
  attribute(2, 2);
}

void GeometryPass::upload_triangles(const Scene& scene) {
  std::vector<std::uint32_t> indices;
  std::vector<Eigen::Vector4f> normals;
  std::uint32_t last = kNone;
  for (const std::uint32_t t : triangles_by_material(scene)) {
    const Triangle& triangle = scene.triangles[t];
    if (triangle.material != last) {
      last = triangle.material;
      const Material& material = scene.materials[last];
      Batch batch;
      batch.first = static_cast<int>(normals.size());
      batch.base << material.base_color, material.base_alpha;
      batch.cutoff = material.alpha_cutoff;
      batch.texture = material.texture;
      batch.masked = material.alpha_mask;
      batches_.push_back(batch);
    }
    ++batches_.back().count;
    indices.insert(indices.end(), triangle.vertex.begin(), triangle.vertex.end());
    normals.emplace_back(triangle_normal(scene, t).homogeneous());
  }
  indices_ = upload(GL_ELEMENT_ARRAY_BUFFER, indices);  // the vertex array keeps it
  glBindVertexArray(0);
  triangle_normals_ = vec4_texels(normals);
}

Program& GeometryPass::program(const Batch& batch) {
  const std::pair key(batch.texture != kNone, batch.masked);
  const auto known = programs_.find(key);
  if (known != programs_.end()) return known->second;
  const std::string defines =
      std::string(key.first ? "#define TEXTURED\n" : "") + (key.second ? "#define MASKED\n" : "");
  return programs_
      .emplace(key, Program::graphics({"geometry_vertex.glsl"},
                                      {"surface.glsl", "geometry_fragment.glsl"}, defines))
      .first->second;
}

/// Infinitely deep: what is nearest has depth 1 (or -1 where depth runs forward).
Eigen::Matrix4f GeometryPass::to_clip(const SceneCamera& camera, const Canvas& canvas) const {
  const Eigen::Matrix3d axes = camera_axes(camera);
  Eigen::Matrix4d to_camera = Eigen::Matrix4d::Identity();
  to_camera.topLeftCorner<3, 3>() = axes.transpose();
  to_camera.topRightCorner<3, 1>() = -axes.transpose() * camera.eye.cast<double>();
  const double scale = view_scale(camera);
  Eigen::Matrix4d projection = Eigen::Matrix4d::Zero();
  projection(0, 0) = scale * canvas.height() / canvas.width();
  projection(1, 1) = scale;
  projection(3, 2) = -1.0;
  projection(2, 3) = near_;
  if (!reversed_depth_) {
    projection(2, 2) = -1.0;
    projection(2, 3) = -2.0 * near_;
  }
  return (projection * to_camera).cast<float>();
}

void GeometryPass::draw(const SceneCamera& camera, const Canvas& canvas) {
  canvas.draw_into();
  if (reversed_depth_) glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(reversed_depth_ ? GL_GREATER : GL_LESS);
  const std::array<GLfloat, 4> nothing{};
  const std::array<GLuint, 4> no_surface{};
  const GLfloat farthest = reversed_depth_ ? 0.0F : 1.0F;
  glClearBufferfv(GL_COLOR, 0, nothing.data());
  glClearBufferuiv(GL_COLOR, 1, no_surface.data());
  glClearBufferfv(GL_DEPTH, 0, &farthest);
  glBindVertexArray(vertices_.id());
  triangle_normals_.read_at(0);
  const Eigen::Matrix4f matrix = to_clip(camera, canvas);
  for (const Batch& batch : batches_) {
    Program& work = program(batch);
    work.use();
    work.set("to_clip", matrix);
    work.set("eye", camera.eye);
    work.set("first_triangle", batch.first);
    work.set("base", batch.base);
    work.set("cutoff", batch.cutoff);
    if (batch.texture != kNone) bind_texture(1, GL_TEXTURE_2D, textures_[batch.texture].id());
    // GL takes the place in the index buffer as a pointer.
    const std::size_t first =
        std::size_t{3} * sizeof(GLuint) * static_cast<std::size_t>(batch.first);
    glDrawElements(GL_TRIANGLES, 3 * batch.count, GL_UNSIGNED_INT,
                   reinterpret_cast<const void*>(first));  // NOLINT(performance-no-int-to-ptr)
  }
  if (reversed_depth_) glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
}

}  // namespace prt::gl
