// The window under a real X server: input comes in through XTEST as from a mouse and a keyboard.
#include <gtest/gtest.h>
#include <stb_image.h>
#include <sys/stat.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "gl/gl_lights.h"
#include "package/write.h"
#include "player/environment_light.h"
#include "player/gl/controls.h"
#include "player/picture.h"
#include "support/picture_difference.h"
#include "support/program.h"

namespace prt {
namespace {

constexpr int kWidth = 800;
constexpr int kHeight = 600;
/// As for pictures without a window (gl_pictures_test).
constexpr double kMeanDifference = 0.01;
constexpr double kBlockDifference = 0.05;
/// Centimetres: numbers are printed in full, pixels are whole.
constexpr float kPlace = 1e-3F;

const gl::Drag kDrag{220, -130};
constexpr float kExposure = 0.15F;
const Light kLight{.position = {1.6F, 1.2F, 2.2F}, .intensity = {9, 8, 7}};

std::vector<std::uint8_t> read_png(const std::string& file) {
  int width = 0;
  int height = 0;
  int channels = 0;
  stbi_uc* pixels = stbi_load(file.c_str(), &width, &height, &channels, 3);
  EXPECT_EQ(width, kWidth);
  EXPECT_EQ(height, kHeight);
  if (pixels == nullptr) return {};
  std::vector<std::uint8_t> rgb(pixels, pixels + std::size_t{3} * width * height);
  stbi_image_free(pixels);
  return rgb;
}

bool run(const std::string& command) { return std::system(command.c_str()) == 0; }

/// prt_play in a window, and what it says, line by line.
class Player {
 public:
  /// `shining`: the option and specification of what lights the room.
  Player(const std::filesystem::path& folder, const std::vector<std::string>& shining) {
    const std::string pipe = (folder / "pipe").string();
    EXPECT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    const std::string play = std::string(PRT_BINARY_DIR) + "/bin/prt_play";
    std::vector<std::string> command{"env",
                                     "-C",
                                     folder.string(),
                                     play,
                                     "room.prt.glb",
                                     "--backend",
                                     "gl",
                                     "--size",
                                     fmt::format("{}x{}", kWidth, kHeight),
                                     "--exposure",
                                     std::to_string(kExposure),
                                     "--json"};
    command.insert(command.end(), shining.begin(), shining.end());
    program_ = std::make_unique<test::Program>(command, pipe);
    said_.open(pipe);
    EXPECT_TRUE(
        run("timeout 30 xdotool search --sync --onlyvisible --name prt_play"
            " windowfocus > /dev/null"));
  }

  /// Asks for a screenshot and waits until it is written.
  std::string screenshot() {
    EXPECT_TRUE(run("xdotool key p"));
    std::string line;
    while (std::getline(said_, line)) {
      const std::size_t at = line.find("wrote ");
      if (at != std::string::npos) return line.substr(at + 6);
    }
    return {};
  }

  /// Ends it; what it printed.
  nlohmann::json end() {
    EXPECT_TRUE(run("xdotool key Escape"));
    const std::string rest(std::istreambuf_iterator<char>(said_), {});
    EXPECT_EQ(program_->wait(), 0);
    return nlohmann::json::parse(rest.substr(rest.find('{')));
  }

 private:
  std::unique_ptr<test::Program> program_;
  std::ifstream said_;
};

TEST(Window, LightFollowsTheMouseAndPictureTheLight) {
  const test::TemporaryFolder folder;
  const Package room = test::synthetic_room();
  write_package(room, folder.path / "room.prt.glb");
  const auto picture_of = [&](const Light& light) {
    const Evaluator evaluator(room);
    return render(evaluator, evaluator.evaluate({&light, 1}), *room.scene.camera,
                  {.width = kWidth, .height = kHeight, .exposure = kExposure})
        .rgb;
  };

  Player player(folder.path, {"--light", "point:1.6,1.2,2.2:9,8,7"});
  const auto before = read_png((folder.path / player.screenshot()).string());
  ASSERT_TRUE(
      run(fmt::format("xdotool mousemove 500 400 mousedown 1 mousemove_relative {} {} "
                      "mousemove_relative -- {} {} mouseup 1",
                      kDrag.x, 0, 0, kDrag.y)));
  const auto after = read_png((folder.path / player.screenshot()).string());
  const nlohmann::json end = player.end().at("end");

  const Light moved = gl::dragged(kLight, kDrag, false, *room.scene.camera, kHeight);
  ASSERT_GT((moved.position - kLight.position).norm(), 0.2F);
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(end.at("lights")[0].at("position")[k].get<float>(), moved.position[k], kPlace);
  }
  const auto expect_picture = [&](const auto& pixels, const Light& light) {
    const auto apart = test::difference(pixels, picture_of(light), kWidth, kHeight);
    EXPECT_LE(apart.mean, kMeanDifference);
    EXPECT_LE(apart.worst_block, kBlockDifference);
  };
  expect_picture(before, kLight);
  expect_picture(after, moved);
  // It would not pass for the picture of the light where it was.
  EXPECT_GT(test::difference(after, picture_of(kLight), kWidth, kHeight).worst_block,
            kBlockDifference);
}

TEST(Window, TheSkyTurnsWithTheMouseWhereThereIsNoLight) {
  const test::TemporaryFolder folder;
  constexpr int kOrder = 4;
  Package room = test::synthetic_room();
  test::add_environment(room, kOrder);
  write_package(room, folder.path / "room.prt.glb");
  const std::string spec = "disc:1,-0.3,0.4:3,2,1:40";
  const auto picture_of = [&](double degrees) {
    const Evaluator evaluator(room);
    const Environment sky = parse_environment(spec).turned(degrees);
    return render(evaluator, evaluator.evaluate({}, EnvironmentLight(sky, kOrder).coefficients()),
                  *room.scene.camera,
                  {.width = kWidth, .height = kHeight, .exposure = kExposure, .environment = &sky})
        .rgb;
  };
  Player player(folder.path, {"--env", spec});
  const auto before = read_png((folder.path / player.screenshot()).string());
  ASSERT_TRUE(run(fmt::format(
      "xdotool mousemove 500 400 mousedown 1 mousemove_relative {} {} mouseup 1", kDrag.x, 0)));
  const auto after = read_png((folder.path / player.screenshot()).string());
  const auto turn = player.end().at("end").at("turn").get<double>();
  EXPECT_GT(std::abs(turn), 20.0);
  const auto off = [&](const auto& pixels, double degrees) {
    return test::difference(pixels, picture_of(degrees), kWidth, kHeight);
  };
  EXPECT_LE(off(before, 0.0).mean, kMeanDifference);
  EXPECT_LE(off(before, 0.0).worst_block, kBlockDifference);
  EXPECT_LE(off(after, turn).mean, kMeanDifference);
  EXPECT_LE(off(after, turn).worst_block, kBlockDifference);
  EXPECT_GT(off(after, 0.0).mean, kMeanDifference);
}

TEST(Window, SaysInOneLineWhatIsMissing) {
  const test::TemporaryFolder folder;
  const std::string room = (folder.path / "room.prt.glb").string();
  write_package(test::synthetic_room(), room);
  const std::string play = std::string(PRT_BINARY_DIR) + "/bin/prt_play";
  const std::vector<std::string> in_window{play, room, "--backend", "gl"};
  std::vector<std::string> without = in_window;
  without.insert(without.end(), {"--out", (folder.path / "picture.png").string()});
  const auto expect_line = [&](const std::vector<std::string>& command, const std::string& name,
                               const std::string& value) {
    test::Program program(command, folder.path / "log", {{name, value}});
    EXPECT_EQ(program.wait(), 2) << name;
    const std::string said = program.output();
    const std::size_t at = said.find("prt_play: --backend gl: ");
    ASSERT_NE(at, std::string::npos) << said;
    EXPECT_EQ(said.find('\n', at), said.size() - 1) << said;
    const bool remedy = said.find("use --backend cpu", at) != std::string::npos ||
                        said.find("give --out", at) != std::string::npos;
    EXPECT_TRUE(remedy) << said;
  };
  expect_line(in_window, "DISPLAY", "");
  expect_line(in_window, "MESA_GL_VERSION_OVERRIDE", "4.2");
  expect_line(without, "MESA_GL_VERSION_OVERRIDE", "4.2");
  expect_line(without, "__EGL_VENDOR_LIBRARY_FILENAMES", "/dev/null");
  EXPECT_FALSE(std::filesystem::exists(folder.path / "picture.png"));
}

}  // namespace
}  // namespace prt
