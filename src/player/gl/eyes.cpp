#include "player/gl/eyes.h"

#include <algorithm>

#include "player/view.h"

namespace prt::gl {

std::vector<SceneCamera> eye_cameras(const SceneCamera& camera, const StereoSettings& stereo) {
  if (!stereo.on) return {camera};
  const Vec3f aside = 0.5F * stereo.eye_distance * camera_axes(camera).col(0).cast<float>();
  std::vector<SceneCamera> eyes(2, camera);
  for (std::size_t k = 0; k < 2; ++k) {
    const Vec3f offset = k == 0 ? Vec3f(-aside) : aside;
    eyes[k].eye += offset;
    eyes[k].target += offset;
  }
  return eyes;
}

Eyes::Eyes(int width, int height, const StereoSettings& stereo, int side) : stereo_(stereo) {
  const int eyes = stereo.on ? 2 : 1;
  for (int k = 0; k < eyes; ++k) views_.emplace_back(std::max(1, width / eyes), height, side);
}

void Eyes::draw(GlRenderer& renderer, const SceneCamera& camera, const Look& look) {
  const std::vector<SceneCamera> cameras = eye_cameras(camera, stereo_);
  for (std::size_t k = 0; k < views_.size(); ++k) renderer.draw(views_[k], cameras[k], look);
}

float Eyes::own_exposure(GlRenderer& renderer, const SceneCamera& camera) {
  return renderer.own_exposure(views_.front(), eye_cameras(camera, stereo_).front());
}

std::vector<std::uint8_t> Eyes::pixels() const {
  if (views_.size() == 1) return views_.front().pixels();
  const auto row = 3 * static_cast<std::ptrdiff_t>(views_.front().width());
  const std::vector<std::uint8_t> left = views_.front().pixels();
  const std::vector<std::uint8_t> right = views_.back().pixels();
  std::vector<std::uint8_t> both;
  both.reserve(2 * left.size());
  for (std::ptrdiff_t y = 0; y < height(); ++y) {
    both.insert(both.end(), left.begin() + y * row, left.begin() + (y + 1) * row);
    both.insert(both.end(), right.begin() + y * row, right.begin() + (y + 1) * row);
  }
  return both;
}

void Eyes::copy(unsigned framebuffer, int scale) const {
  int x = 0;
  for (const GlView& view : views_) {
    view.copy(framebuffer, x, 0, scale);
    x += scale * view.width();
  }
}

void Eyes::wait() const {
  for (const GlView& view : views_) static_cast<void>(view.pixel(0, 0));
}

}  // namespace prt::gl
