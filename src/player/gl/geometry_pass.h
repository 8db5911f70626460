// Draws the scene into what the other passes read per pixel. Internal to player/gl.
#pragma once

#include <map>
#include <memory>

#include "player/gl/objects.h"
#include "scene/scene.h"

namespace prt::gl {

class GeometryPass {
 public:
  /// Geometry and textures go to the GL; the scene need not live on.
  explicit GeometryPass(const Scene& scene);

  /// `canvas` has a vec4 image, an index image and depth (shaders/geometry_fragment.glsl).
  void draw(const SceneCamera& camera, const Canvas& canvas);

 private:
  struct Batch {  // triangles of one material
    int first = 0;
    int count = 0;
    Eigen::Vector4f base;
    float cutoff = 0.0F;
    std::size_t texture = 0;  // kNone: none
    bool masked = false;
  };
  void upload_vertices(const Scene& scene);
  void upload_triangles(const Scene& scene);
  Program& program(const Batch& batch);
  [[nodiscard]] Eigen::Matrix4f to_clip(const SceneCamera& camera, const Canvas& canvas) const;

  float near_;
  bool reversed_depth_;
  std::vector<Batch> batches_;
  Name vertices_, positions_, normals_, uvs_, indices_;
  TexelBuffer triangle_normals_;
  std::vector<Name> textures_;
  std::map<std::pair<bool, bool>, Program> programs_;
};

}  // namespace prt::gl
