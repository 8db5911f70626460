#include "apps/prt_play_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>

#include "apps/program.h"
#include "base/error.h"
#include "scene/environment.h"

namespace prt {
namespace {

/// What the parser fills in, before it is checked as a whole.
struct Words {
  std::vector<std::string> lights;
  std::string backend = "cpu", camera, size = "1024x768", show = "full";
  float exposure = 1.0F;
};

/// Exactly N numbers with `separator` between them.
template <typename T, std::size_t N>
bool split(const std::string& text, char separator, std::array<T, N>& values) {
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i > 0 && (at == end || *at++ != separator)) return false;
    const auto [next, error] = std::from_chars(at, end, values[i]);
    if (error != std::errc()) return false;
    at = next;
  }
  return at == end;
}

WorldCamera parse_camera(const std::string& text) {
  std::array<double, 7> n{};
  bool sound = split(text, ',', n);
  for (const double v : n) sound = sound && std::isfinite(static_cast<float>(v));
  WorldCamera camera{
      {n[0], n[1], n[2]}, {n[3], n[4], n[5]}, static_cast<float>(n[6]) * kPi / 180.0F};
  if (!sound || !(n[6] > 0.0 && n[6] < 170.0) || camera.eye == camera.target) {
    throw UserError(
        fmt::format("--camera {}: should be ex,ey,ez,tx,ty,tz,fov: eye and target (m, not the same "
                    "point) and the vertical field of view (degrees, below 170)",
                    text));
  }
  return camera;
}

void parse_size(const std::string& text, PictureSettings& picture) {
  std::array<int, 2> n{};
  if (!split(text, 'x', n) || n[0] < 1 || n[1] < 1 || n[0] > 8192 || n[1] > 8192) {
    throw UserError(fmt::format("--size {}: should be WIDTHxHEIGHT in pixels, up to 8192", text));
  }
  picture.width = n[0];
  picture.height = n[1];
}

#ifdef PRT_HAVE_GL
constexpr bool kHaveGl = true;
#else
constexpr bool kHaveGl = false;
#endif

void refuse_what_is_not_built(const Words& words, const PlayCommand& command) {
  if (words.backend == "gl" && !kHaveGl) {
    throw UserError("--backend gl: not built into this program; use --backend cpu");
  }
  if (command.stereo && !command.gl) {
    throw UserError("--stereo: only --backend gl draws two eyes");
  }
  if (command.environment.empty() && command.picture.reflection > 0.0F) {
    throw UserError("--reflection: needs an --env that is mirrored");
  }
  if (command.out.empty()) return;
  const std::string extension = std::filesystem::path(command.out).extension().string();
  if (extension != ".png" && extension != ".exr") {
    throw UserError(fmt::format("--out {}: should end in .png or .exr", command.out));
  }
  if (extension == ".exr" && (words.show == "visibility" || words.show == "clusters")) {
    throw UserError(fmt::format(
        "--out {}: OpenEXR pictures hold radiance; use --show full, direct or indirect, "
        "or a .png",
        command.out));
  }
}

void add_options(CLI::App& app, Words& words, PlayCommand& command) {
  app.add_option("PACKAGE", command.package, "runtime package (.prt.glb)")->required();
  app.add_option("--backend", words.backend,
                 kHaveGl ? "cpu, or gl: OpenGL 4.3 core, in a window unless --out or --bench is "
                           "given"
                         : "cpu (gl: not built into this program)")
      ->check(CLI::IsMember({"cpu", "gl"}));
  app.add_option("--light", words.lights,
                 "a light: point:x,y,z:r,g,b | sphere:x,y,z:r,g,b:radius | "
                 "spot:x,y,z:dx,dy,dz:r,g,b:inner_deg,outer_deg | "
                 "quad:cx,cy,cz:ux,uy,uz:vx,vy,vz:r,g,b | sun:dx,dy,dz:r,g,b; W/sr, quad "
                 "W/(m² sr), sun W/m²; places in the scene file's world, m (default: the scene's "
                 "first light, else one that is seen from most places)")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->type_name("SPEC");
  app.add_option("--env", command.environment,
                 std::string("light from infinitely far away, in packages with an environment "
                             "layer: ") +
                     kEnvironmentForms)
      ->type_name("FILE.hdr|.exr|SPEC");
  app.add_option("--rotate", command.rotate,
                 "turn the environment about the vertical, counter-clockwise from above")
      ->check(finite_number())
      ->check(CLI::Range(-1e4, 1e4))
      ->type_name("DEGREES");
  app.add_option("--reflection", command.picture.reflection,
                 "share of the environment that surfaces mirror beside their diffuse light; for "
                 "looks, it is not in prt_eval's figures")
      ->check(finite_number())
      ->check(CLI::Range(0.0, 1.0))
      ->type_name("F");
  app.add_option(
         "--camera", words.camera,
         "eye and target (m, in the scene file's world) and vertical field of view (degrees) "
         "(default: the scene's camera, else a view of the sampled space)")
      ->type_name("ex,ey,ez,tx,ty,tz,fov");
  app.add_option("--size", words.size, "pixels of the picture")->type_name("WxH");
  app.add_option("--show", words.show, "what the picture shows")
      ->check(CLI::IsMember({"full", "direct", "indirect", "visibility", "clusters"}));
  app.add_option("--area-samples", command.area_samples, "points on each area light")
      ->check(CLI::Range(1, 4096))
      ->type_name("N");
  app.add_flag("--stereo", command.stereo, "side by side for a headset (gl); --size is of both");
  app.add_option("--eye-distance", command.eye_distance, "of --stereo, m")
      ->check(finite_number())
      ->check(CLI::Range(0.0, 10.0))
      ->capture_default_str()
      ->type_name("M");
  app.add_option("--exposure", words.exposure,
                 "factor on radiance before the filmic curve (default: the picture's own)")
      ->check(finite_number())
      ->check(CLI::PositiveNumber)
      ->type_name("F");
  app.add_option("--out", command.out,
                 "write the picture: .png as shown, .exr linear radiance in W/(m² sr)")
      ->type_name("FILE.png|.exr");
  app.add_option("--bench", command.bench_seconds,
                 "measure light changes and pictures for this long")
      ->check(finite_number())
      ->check(CLI::Range(0.0, 3600.0))
      ->type_name("SECONDS");
  app.add_flag("--json", command.json, "print figures as JSON on standard output");
}

}  // namespace

SceneCamera WorldCamera::in(const Vec3d& origin) const {
  SceneCamera camera;
  camera.eye = relative_to(origin, eye);
  camera.target = relative_to(origin, target);
  camera.vertical_fov = vertical_fov;
  if (camera.eye == camera.target) {
    throw UserError(
        "--camera: so far from the scene, eye and target are one point in float; move the target "
        "away from the eye");
  }
  return camera;
}

std::optional<PlayCommand> parse_play_command(int argc, char** argv, std::string& message) {
  PlayCommand command;
  Words words;
  CLI::App app{"Shows a package under lights of your choice.", "prt_play"};
  add_options(app, words, command);
  if (!parse_arguments(app, argc, argv, message)) return std::nullopt;
  static const std::map<std::string, Show> shows = {{"full", Show::kFull},
                                                    {"direct", Show::kDirect},
                                                    {"indirect", Show::kIndirect},
                                                    {"visibility", Show::kVisibility},
                                                    {"clusters", Show::kClusters}};
  command.gl = words.backend == "gl";
  refuse_what_is_not_built(words, command);
  command.picture.show = shows.at(words.show);
  parse_size(words.size, command.picture);
  command.picture.linear = std::filesystem::path(command.out).extension() == ".exr";
  if (app.count("--exposure") > 0) command.picture.exposure = words.exposure;
  if (!words.camera.empty()) command.camera = parse_camera(words.camera);
  for (const std::string& light : words.lights) command.lights.push_back(parse_light(light));
  return command;
}

}  // namespace prt
