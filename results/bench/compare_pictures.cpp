// The path-traced reference, the CPU's and the GL's picture of a package side by side, with the
// difference of the CPU's from the reference, one JPEG per light; figures as a table on stdout.
//   compare_pictures out/paper/paper.prt.glb configs/scenes/gallery.glb FOLDER PATHS NAME=LIGHT...
// Lights are written as for prt_play --light. What differs from the reference is shown in grey, 0.5
// where nothing does, by half of what the exposed pictures differ in; noise of the reference is in
// it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "base/error.h"
#include "base/image_file.h"
#include "base/random.h"
#include "evaluate/reference.h"
#include "package/read.h"
#include "player/gl/offscreen.h"
#include "player/gl/renderer.h"
#include "player/picture.h"
#include "player/set_up.h"
#include "player/tone.h"
#include "player/visible_surfaces.h"
#include "scene/embree/embree_ray_caster.h"
#include "scene/load.h"

namespace prt {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 240;
constexpr int kQuality = 85;

using Pixels = std::vector<Vec3f>;  ///< radiance, W/(m² sr), top row first

Pixels pixels_of(const std::vector<float>& radiance) {
  Pixels pixels;
  for (std::size_t i = 0; i < radiance.size(); i += 3) {
    pixels.emplace_back(radiance[i], radiance[i + 1], radiance[i + 2]);
  }
  return pixels;
}

/// What the camera sees, path traced at the middle of each pixel. A pixel's cosine is that of its
/// shading normal, as in the player.
class Reference {
 public:
  Reference(const Package& package, const Scene& scene, const SceneCamera& camera)
      : scene_(scene),
        caster_(make_embree_ray_caster(scene)),
        seen_(visible_surfaces(package.scene, camera.eye,
                               rasterise(package.scene, camera, kWidth, kHeight), 0)) {
    for (const PlayPoint& p : seen_.points) points_.push_back({p.position, p.shading_normal});
  }

  [[nodiscard]] Pixels picture(const Light& light, int paths, std::uint64_t seed) const {
    const auto traced = trace_in_parallel(scene_, *caster_, {&light, 1}, points_, {.paths = paths},
                                          stream_key(seed, "compare pictures"), 0, [] {});
    Pixels pixels(std::size_t{kWidth} * kHeight, Vec3f::Zero());
    for (std::size_t i = 0; i < traced.size(); ++i) {
      pixels[seen_.place[i]] =
          seen_.albedo[i].cwiseProduct(traced[i].mean_direct() + traced[i].mean_indirect()) / kPi;
    }
    return pixels;
  }

 private:
  const Scene& scene_;
  std::unique_ptr<RayCaster> caster_;
  VisibleSurfaces seen_;
  std::vector<ReceiverPoint> points_;
};

double relative_error(const Pixels& a, const Pixels& b) {
  double off = 0.0;
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    off += (a[i] - b[i]).squaredNorm();
    sum += b[i].squaredNorm();
  }
  return std::sqrt(off / sum);
}

/// Of what is shown, a share of full scale.
double mean_difference(const Pixels& a, const Pixels& b, float exposure) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Vec3f x = filmic(exposure * a[i]);
    const Vec3f y = filmic(exposure * b[i]);
    for (int c = 0; c < 3; ++c)
      sum += std::abs(int{srgb_byte(x[c])} - int{srgb_byte(y[c])}) / 255.0;
  }
  return sum / (3.0 * static_cast<double>(a.size()));
}

/// Reference, CPU, GL, difference, left to right.
std::string panel(const Pixels& reference, const Pixels& cpu, const Pixels& gl, float exposure) {
  std::vector<std::uint8_t> rgb;
  for (std::size_t y = 0; y < kHeight; ++y) {
    for (const Pixels* picture : {&reference, &cpu, &gl}) {
      for (std::size_t x = 0; x < kWidth; ++x) {
        for (const float value : filmic(exposure * (*picture)[y * kWidth + x])) {
          rgb.push_back(srgb_byte(value));
        }
      }
    }
    for (std::size_t i = y * kWidth; i < (y + 1) * kWidth; ++i) {
      for (const float value : Vec3f(exposure * (cpu[i] - reference[i]))) {
        rgb.push_back(static_cast<std::uint8_t>(
            std::lround(255.0F * std::clamp(0.5F + 0.5F * value, 0.0F, 1.0F))));
      }
    }
  }
  return encode_jpeg(4 * kWidth, kHeight, rgb, kQuality);
}

void compare(const std::vector<std::string>& words) {
  const Package package = read_package(words[0]);
  const Scene scene = load_scene(words[1]);
  const int paths = std::stoi(words[3]);
  const Evaluator cpu(package);
  const gl::OffscreenContext context;
  gl::GlRenderer renderer(package);
  gl::GlView view(kWidth, kHeight);
  const SceneCamera camera = default_camera(cpu);
  const Reference reference(package, scene, camera);
  fmt::print(
      "| light | CPU from the reference | its noise | GL from the CPU |\n| --- | --- | --- | --- "
      "|\n");
  for (std::size_t k = 4; k < words.size(); ++k) {
    const std::size_t equals = words[k].find('=');
    if (equals == std::string::npos) throw UserError(words[k] + ": should be NAME=LIGHT");
    const Light light = parse_light(words[k].substr(equals + 1)).in(package.scene.origin);
    const Pixels traced = reference.picture(light, paths, 1);
    const Pixels fewer = reference.picture(light, std::max(2, paths / 4), 2);
    const Picture played = render(cpu, cpu.evaluate({&light, 1}), camera,
                                  {.width = kWidth, .height = kHeight, .linear = true});
    const Pixels drawn = pixels_of(played.radiance);
    renderer.set_lights({&light, 1});
    const Pixels on_gl = pixels_of(renderer.radiance(view, camera, {}));
    const std::string name = words[k].substr(0, equals);
    std::ofstream(std::filesystem::path(words[2]) / (name + ".jpg"), std::ios::binary)
        << panel(traced, drawn, on_gl, played.exposure);
    // A quarter of the paths has twice the noise; both together differ by √5 times that of all.
    fmt::print("| {} | {:.1f} %, {:.2f} % of full scale | {:.1f} % | {:.2f} % of full scale |\n",
               name, 100.0 * relative_error(drawn, traced),
               100.0 * mean_difference(drawn, traced, played.exposure),
               100.0 * relative_error(fewer, traced) / std::sqrt(5.0),
               100.0 * mean_difference(on_gl, drawn, played.exposure));
  }
}

}  // namespace
}  // namespace prt

int main(int argc, char** argv) try {
  if (argc < 6)
    throw prt::UserError("usage: compare_pictures PACKAGE SCENE FOLDER PATHS NAME=LIGHT...");
  prt::compare({argv + 1, argv + argc});
  return 0;
} catch (const std::exception& e) {
  fmt::print(stderr, "compare_pictures: {}\n", e.what());
  return 1;
}
