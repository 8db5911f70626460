// The command line of prt_play.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "player/picture.h"
#include "scene/light.h"

namespace prt {

/// A camera as a user types it.
struct WorldCamera {
  Vec3d eye, target;          ///< m, world
  float vertical_fov = 0.0F;  ///< radians
  /// In a scene of that origin. Throws UserError where float cannot tell eye and target apart.
  [[nodiscard]] SceneCamera in(const Vec3d& origin) const;
};

/// Pixels of a picture that is kept are averaged over the square of so many samples.
inline constexpr int kKeptSamples = 2;

struct PlayCommand {
  std::string package;
  bool gl = false;                 ///< the GL back end
  std::vector<WorldLight> lights;  ///< none given: the player chooses
  std::string environment;         ///< spec; empty: none, or the player's choice
  double rotate = 0.0;             ///< of the environment, degrees about +Y
  std::optional<WorldCamera> camera;
  PictureSettings picture;
  int area_samples = 25;
  bool stereo = false;          ///< two eyes side by side
  float eye_distance = 0.063F;  ///< m
  std::string out;              ///< .png, or .exr: linear; empty: no picture is kept
  double bench_seconds = 0.0;   ///< 0: no bench
  bool json = false;
};

/// Empty when the answer is text for standard output (--help), which `message` then holds. Throws
/// UserError for a command line that is not understood.
std::optional<PlayCommand> parse_play_command(int argc, char** argv, std::string& message);

}  // namespace prt
