// The command line of prt_play.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "player/picture.h"
#include "scene/light.h"

namespace prt {

struct PlayCommand {
  std::string package;
  std::vector<Light> lights;  ///< none given: the player chooses
  std::optional<SceneCamera> camera;
  PictureSettings picture;
  int area_samples = 25;
  std::string out;             ///< .png; empty: no picture is kept
  double bench_seconds = 0.0;  ///< 0: no bench
  bool json = false;
};

/// Empty when the answer is text for standard output (--help), which `message` then holds. Throws
/// UserError for a command line that is not understood.
std::optional<PlayCommand> parse_play_command(int argc, char** argv, std::string& message);

}  // namespace prt
