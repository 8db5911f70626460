// What is done per pixel: finding its samples, light and colour. Internal to player/gl.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "player/gl/interpreter.h"
#include "player/gl/renderer.h"
#include "player/gl/splat_cells.h"

namespace prt::gl {

class SplatPass {
 public:
  SplatPass(const SampleSet& samples, const SampleBuffers& buffers);
  /// From surfaces (geometry pass) to three index images. `weak` has pixels look for the weakest
  /// kernels, too: slow, and only the picture of visibility shows them.
  void draw(const Canvas& surfaces, const Canvas& splats, bool weak);

 private:
  SplatPass(const SplatField& field, const SampleSet& samples, const SampleBuffers& buffers);
  Program& program(bool weak);
  [[nodiscard]] Program make_program(const std::string& defines) const;
  const SampleBuffers* samples_;
  CellLists kernels_;
  CellLists plain_;
  float widest_, fallback_;  // m
  std::optional<Program> program_, weak_program_;
  ScreenTriangle screen_;
};

/// What a picture's colours are made of.
enum class Colours { kDisplay, kRadiance, kVisibility, kClusters };

/// The picture of an environment in the GL's memory.
class EnvironmentImage {
 public:
  /// Throws UserError where this GL has no room for it.
  explicit EnvironmentImage(const Environment& environment);
  void read_at(GLuint texture_unit) const;
  [[nodiscard]] float turn() const { return turn_; }

 private:
  Name texture_;
  float turn_;
};

struct ShadeInput {
  const Canvas* surfaces;
  const Canvas* splats;
  const LightTable* lights;
  const SampleFields* fields;
  const SceneCamera* camera;
  const EnvironmentImage* environment;  ///< null: none
};

class ShadePass {
 public:
  ShadePass(std::size_t clusters, const SampleBuffers& samples);
  void draw(const ShadeInput& input, Colours colours, const Look& look, const Canvas& picture);

 private:
  Program& program(const ShadeInput& input, Colours colours);
  const SampleBuffers* samples_;
  TexelBuffer cluster_colours_;
  std::map<std::string, Program> programs_;
  ScreenTriangle screen_;
};

}  // namespace prt::gl
