// prt_bake as a library: the program with its methods and libraries put in, so that tests can bake
// with a toy method and a toy scene through the same code.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "apps/bake/evaluator.h"
#include "apps/bake/report_pictures.h"
#include "base/clock.h"
#include "methods/method.h"
#include "scene/scene.h"
#include "store/file_system.h"

namespace prt {

struct BakeProgram {
  std::vector<const Method*> methods;
  /// Null: a bake does not measure its error.
  std::shared_ptr<const BakeErrorMeter> evaluator;
  std::function<Scene(const std::filesystem::path&)> load_scene;
  std::function<std::unique_ptr<RayCaster>(const Scene&, const std::string& isa)> make_ray_caster;
  /// Highest instruction set of this machine, as make_ray_caster takes it.
  std::function<std::string()> best_isa;
  /// The runtime package's bytes.
  std::function<std::vector<std::byte>(const Package&)> encode_package;
  /// Where the bake's folder lies.
  std::shared_ptr<FileSystem> file_system = std::make_shared<PosixFileSystem>();
  /// Seconds, never running backwards: what a time limit is held against.
  std::function<double()> clock = steady_seconds;
  /// Pictures for report.html; null: it has none.
  DrawReportPictures draw_pictures = nullptr;
};

/// The whole program; the result is its exit code.
int bake_main(int argc, char** argv, const BakeProgram& program);

}  // namespace prt
