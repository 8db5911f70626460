// One picture from one camera, or two side by side for the eyes of a headset.
#pragma once

#include <vector>

#include "player/gl/renderer.h"

namespace prt::gl {

struct StereoSettings {
  bool on = false;
  float eye_distance = 0.063F;  ///< m; the mean of grown-ups
};

/// Cameras of the left and right eye: apart along the camera's right, with parallel views.
std::vector<SceneCamera> eye_cameras(const SceneCamera& camera, const StereoSettings& stereo);

/// A picture of width × height pixels; in stereo each eye has half the width.
class Eyes {
 public:
  Eyes(int width, int height, const StereoSettings& stereo, int side = 1);

  void draw(GlRenderer& renderer, const SceneCamera& camera, const Look& look);
  [[nodiscard]] float own_exposure(GlRenderer& renderer, const SceneCamera& camera,
                                   const Look& look = {});
  /// 8-bit sRGB, top row first.
  [[nodiscard]] std::vector<std::uint8_t> pixels() const;
  /// As GlRenderer::radiance.
  [[nodiscard]] std::vector<float> radiance(GlRenderer& renderer, const SceneCamera& camera,
                                            const Look& look);
  /// As GlView::copy.
  void copy(unsigned framebuffer, int scale = 1) const;
  /// Waits until the picture is done.
  void wait() const;
  [[nodiscard]] int width() const {
    return views_.front().width() * static_cast<int>(views_.size());
  }
  [[nodiscard]] int height() const { return views_.front().height(); }

 private:
  StereoSettings stereo_;
  std::vector<GlView> views_;  // left to right
};

}  // namespace prt::gl
