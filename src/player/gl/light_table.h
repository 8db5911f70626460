// Lights as shaders read them (shaders/lights.glsl). Internal to player/gl.
#pragma once

#include <span>
#include <string>

#include "player/gl/objects.h"
#include "scene/light.h"

namespace prt::gl {

class LightTable {
 public:
  /// `area_samples` as in PlayerSettings.
  LightTable(std::span<const Light> lights, int area_samples);
  void bind() const;
  [[nodiscard]] int count() const { return count_; }
  /// Definitions of the kinds of light that are in the table.
  [[nodiscard]] const std::string& defines() const { return defines_; }

 private:
  int count_;
  std::string defines_;
  TexelBuffer table_;
  TexelBuffer points_;
};

}  // namespace prt::gl
