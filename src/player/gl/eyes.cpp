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

float Eyes::own_exposure(GlRenderer& renderer, const SceneCamera& camera, const Look& look) {
  return renderer.own_exposure(views_.front(), eye_cameras(camera, stereo_).front(), look);
}

namespace {

/// Rows of three values a pixel next to each other.
template <typename T>
std::vector<T> side_by_side(const std::vector<T>& left, const std::vector<T>& right, int width) {
  const auto row = 3 * static_cast<std::ptrdiff_t>(width);
  std::vector<T> both;
  both.reserve(2 * left.size());
  for (std::ptrdiff_t at = 0; at < static_cast<std::ptrdiff_t>(left.size()); at += row) {
    both.insert(both.end(), left.begin() + at, left.begin() + at + row);
    both.insert(both.end(), right.begin() + at, right.begin() + at + row);
  }
  return both;
}

}  // namespace

std::vector<std::uint8_t> Eyes::pixels() const {
  if (views_.size() == 1) return views_.front().pixels();
  return side_by_side(views_.front().pixels(), views_.back().pixels(), views_.front().width());
}

std::vector<float> Eyes::radiance(GlRenderer& renderer, const SceneCamera& camera,
                                  const Look& look) {
  const std::vector<SceneCamera> cameras = eye_cameras(camera, stereo_);
  std::vector<float> first = renderer.radiance(views_.front(), cameras.front(), look);
  if (views_.size() == 1) return first;
  return side_by_side(first, renderer.radiance(views_.back(), cameras.back(), look),
                      views_.front().width());
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
